#include "checkpoint/population_file.hpp"
#include "component/progress.hpp"
#include "solver/lattice_boltzmann.hpp"

// A checkpoint holds populations by cell and direction, wherever the step's parity stored them, and the
// kinematics of the last exchange: which cells were covered decides which are uncovered next.

namespace copepod::fluid {

template <class T>
template <class Visit>
void LatticeBoltzmann<T>::for_each_population(const Visit& visit) const {
  const Box& block = layout_.block();
  for (std::int64_t x = block.low[0]; x < block.high[0]; ++x) {
    for (std::int64_t y = block.low[1]; y < block.high[1]; ++y)
      for (std::int64_t z = block.low[2]; z < block.high[2]; ++z)
        for (int alpha = 0; alpha < d3q19::directions; ++alpha)
          visit(static_cast<std::size_t>(layout_.location(layout_.site(Cell{x, y, z}), alpha, placement_)));
    report_progress();
  }
}

template <class T>
void LatticeBoltzmann<T>::save(const std::string& path) {
  check_all_rows();
  std::vector<T> populations;
  populations.reserve(static_cast<std::size_t>(layout_.block().volume() * d3q19::directions));
  for_each_population([&](std::size_t location) { populations.push_back(populations_[location]); });
  save_populations<T>(path, communicator_, {digest_of(setup_), domain_.cells(), step_}, layout_.block(),
                      populations, {mapped_, output_.mean(), output_.sampling()});
}

template <class T>
void LatticeBoltzmann<T>::restore(const std::string& path) {
  std::vector<T> populations(static_cast<std::size_t>(layout_.block().volume() * d3q19::directions));
  FluidState state;
  const PopulationHeader header = restore_populations<T>(
      path, communicator_, {digest_of(setup_), domain_.cells(), 0}, layout_.block(), populations, state);
  step_ = header.step;
  placement_ = step_ % 2 == 0 ? Placement::home : Placement::streamed;
  std::size_t next = 0;
  for_each_population([&](std::size_t location) { populations_[location] = populations[next++]; });
  output_.restore(step_, state.sampling, std::move(state.mean));
  mapped_ = state.kinematics;
  map_bodies(mapped_);
  map_.accept_fresh_cells();
}

template void LatticeBoltzmann<float>::save(const std::string&);
template void LatticeBoltzmann<double>::save(const std::string&);
template void LatticeBoltzmann<float>::restore(const std::string&);
template void LatticeBoltzmann<double>::restore(const std::string&);

}  // namespace copepod::fluid
