#include "lattice_boltzmann/lattice_boltzmann.hpp"
#include "lattice_boltzmann/output/population_file.hpp"

// A checkpoint holds populations by cell and direction, wherever the step's parity stored them, and the
// kinematics of the last exchange: which cells were covered decides which are uncovered next.

namespace copepod::fluid {

template <class T>
template <class Visit>
void LatticeBoltzmann<T>::for_each_population(const Box& piece, Placement placement,
                                              const Visit& visit) const {
  for (std::int64_t x = piece.low[0]; x < piece.high[0]; ++x)
    for (std::int64_t y = piece.low[1]; y < piece.high[1]; ++y)
      for (std::int64_t z = piece.low[2]; z < piece.high[2]; ++z)
        for (int alpha = 0; alpha < d3q19::directions; ++alpha)
          visit(static_cast<std::size_t>(layout_.location(layout_.site(Cell{x, y, z}), alpha, placement)));
}

template <class T>
void LatticeBoltzmann<T>::save(const std::string& path) {
  check_all_rows();
  const auto get = [this](const Box& piece, std::span<T> populations) {
    auto next = populations.begin();
    for_each_population(piece, placement_, [&](std::size_t location) { *next++ = populations_[location]; });
  };
  save_populations<T>(path, communicator_, {digest_of(setup_), domain_.cells(), step_}, layout_.block(), get,
                      {mapped_, output_.mean(), output_.sampling()});
}

template <class T>
void LatticeBoltzmann<T>::restore(const std::string& path) {
  const auto placement_after = [](std::int64_t step) {
    return step % 2 == 0 ? Placement::home : Placement::streamed;
  };
  const auto take = [&](const PopulationHeader& header, const Box& piece, std::span<const T> populations) {
    auto next = populations.begin();
    for_each_population(piece, placement_after(header.step),
                        [&](std::size_t location) { populations_[location] = *next++; });
  };
  FluidState state;
  step_ = restore_populations<T>(path, communicator_, {digest_of(setup_), domain_.cells(), 0},
                                 layout_.block(), take, state)
              .step;
  placement_ = placement_after(step_);
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
