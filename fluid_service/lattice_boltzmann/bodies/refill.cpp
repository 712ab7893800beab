#include "lattice_boltzmann/bodies/refill.hpp"

#include <algorithm>
#include <map>
#include <span>

#include "lattice_boltzmann/kernel/equilibrium.hpp"
#include "lattice_boltzmann/lattice/moments_of_cell.hpp"

namespace copepod::fluid {

template <class T>
std::int64_t Refill<T>::linear(const Cell& cell) const {
  const Cell& cells = domain_.cells();
  return (cell[0] * cells[1] + cell[1]) * cells[2] + cell[2];
}

template <class T>
void Refill<T>::operator()(T* populations, Placement placement, const BodyMap& map) {
  uncovered_.clear();
  needed_.clear();
  offered_.clear();
  if (map.uncovered().empty()) return;
  look_around(populations, placement, map);
  exchange_densities();
  for (Uncovered& site : uncovered_) fill(populations, placement, map, site);
}

/// Collects the densities that this rank knows, those that it needs, and those that others need from it.
template <class T>
void Refill<T>::look_around(const T* populations, Placement placement, const BodyMap& map) {
  const Box& block = layout_.block();
  for (const BodyMap::ChangedCell& uncovered : map.uncovered()) {
    const bool ours = block.contains(uncovered.cell);
    const Cell domain_cell = domain_.canonical(uncovered.cell).value();
    const int rank = partition_.owner(domain_cell);
    if (!ours && rank == communicator_.rank())
      continue;  // an image of a cell of ours, which is in the list itself
    if (ours) uncovered_.push_back({&uncovered, linear(domain_cell), {}});
    for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
      const auto& e = d3q19::e[alpha];
      const Cell neighbour = {uncovered.cell[0] + e[0], uncovered.cell[1] + e[1], uncovered.cell[2] + e[2]};
      const bool neighbour_ours = block.contains(neighbour);
      if (!ours && !neighbour_ours) continue;
      const auto source = domain_.canonical(neighbour);
      if (!source || map.owner(layout_.cell(neighbour)) != BodyMap::fluid) continue;
      const int source_rank = partition_.owner(*source);
      if (!ours) {
        offered_.push_back(
            {rank, linear(domain_cell), linear(*source), layout_.cell(neighbour),
             excess_density_of_cell(populations, layout_, layout_.site(neighbour), placement)});
      } else if (source_rank != communicator_.rank()) {
        needed_.push_back({source_rank, linear(domain_cell), linear(*source), 0, 0.0});
      } else {
        uncovered_.back().densities.push_back(
            excess_density_of_cell(populations, layout_, layout_.site(*source), placement));
      }
    }
  }
}

template <class T>
void Refill<T>::exchange_densities() {
  if (needed_.empty() && offered_.empty()) return;
  std::sort(needed_.begin(), needed_.end());
  std::sort(offered_.begin(), offered_.end());
  struct Buffers {
    std::vector<double> send;
    std::vector<double> receive;
  };
  std::map<int, Buffers> peers;
  for (const Request& request : offered_) peers[request.rank].send.push_back(request.density);
  for (const Request& request : needed_) peers[request.rank].receive.push_back(0.0);
  std::vector<Communicator::Message> messages;
  messages.reserve(peers.size());
  for (auto& [rank, buffers] : peers)
    messages.push_back(
        {rank, std::as_bytes(std::span(buffers.send)), std::as_writable_bytes(std::span(buffers.receive))});
  communicator_.start_exchange(messages)();

  std::map<int, std::size_t> next;
  for (const Request& request : needed_) {
    const double density = peers[request.rank].receive[next[request.rank]++];
    for (Uncovered& site : uncovered_)
      if (site.linear == request.uncovered) site.densities.push_back(density);
  }
}

template <class T>
void Refill<T>::fill(T* populations, Placement placement, const BodyMap& map, Uncovered& site) const {
  // Sorted, so that the sum depends neither on the decomposition nor on which mirror image it is.
  std::sort(site.densities.begin(), site.densities.end());
  double excess_density = 0.0;
  for (const double density : site.densities) excess_density += density;
  if (!site.densities.empty()) excess_density /= static_cast<double>(site.densities.size());

  const LatticeBody& body = map.bodies()[static_cast<std::size_t>(site.cell->body)];
  const Eigen::Vector3d u = body.surface_velocity(domain_.from_position(body.position, site.cell->cell));
  const double velocity[3] = {u[0], u[1], u[2]};
  const Site cell = layout_.site(site.cell->cell);
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    populations[layout_.location(cell, alpha, placement)] =
        static_cast<T>(equilibrium_deviation(alpha, excess_density, velocity));
}

template class Refill<float>;
template class Refill<double>;

}  // namespace copepod::fluid
