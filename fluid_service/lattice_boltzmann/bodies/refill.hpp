#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "lattice_boltzmann/bodies/body_map.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Gives uncovered cells their populations [paper, section 2.3]: equilibrium with the surface velocity of the
/// body that left and the mean density of the neighbouring fluid cells (cells uncovered in the same step do
/// not count; without a fluid neighbour the density is that of the fluid at rest).
///
/// Densities of neighbours on other ranks travel only in steps in which a cell beside the border is
/// uncovered: both sides see it in their own map and know the size and order of the message without asking.
template <class T>
class Refill {
 public:
  Refill(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
         Communicator& communicator)
      : domain_(domain), partition_(partition), layout_(layout), communicator_(communicator) {}

  /// Refills the cells of `map.uncovered()` that this rank owns.
  void operator()(T* populations, Placement placement, const BodyMap& map);

 private:
  struct Request {
    int rank = 0;
    std::int64_t uncovered = 0;  ///< linear index of the uncovered domain cell
    std::int64_t neighbour = 0;  ///< linear index of the domain cell whose density is needed
    std::int64_t cell = 0;       ///< index in the layout, on the side that knows the density
    double density = 0.0;
    bool operator<(const Request& other) const {
      return std::tie(rank, uncovered, neighbour) < std::tie(other.rank, other.uncovered, other.neighbour);
    }
  };
  struct Uncovered {
    const BodyMap::ChangedCell* cell = nullptr;
    std::int64_t linear = 0;
    std::vector<double> densities;
  };

  [[nodiscard]] std::int64_t linear(const Cell& cell) const;
  void look_around(const T* populations, Placement placement, const BodyMap& map);
  void exchange_densities();
  void fill(T* populations, Placement placement, const BodyMap& map, Uncovered& site) const;

  const Domain& domain_;
  const BlockPartition& partition_;
  const PopulationLayout& layout_;
  Communicator& communicator_;
  std::vector<Uncovered> uncovered_;
  std::vector<Request> needed_;
  std::vector<Request> offered_;
};

}  // namespace copepod::fluid
