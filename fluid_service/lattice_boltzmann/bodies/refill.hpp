#pragma once

#include <memory>

#include "lattice_boltzmann/bodies/body_map.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Gives uncovered cells their populations, by a refill formula (refill_formula.hpp). Cells uncovered in the
/// same step do not count as neighbours.
///
/// What neighbours on other ranks contribute travels only in steps in which a cell beside the border is
/// uncovered: both sides see it in their own map and know the size and order of the message without asking.
template <class T>
class Refiller {
 public:
  Refiller() = default;
  Refiller(const Refiller&) = delete;
  Refiller& operator=(const Refiller&) = delete;
  virtual ~Refiller() = default;

  /// Refills the cells of `map.uncovered()` that this rank owns; collective.
  virtual void operator()(T* populations, Placement placement, const BodyMap& map) = 0;
};

/// With the refill formula of a case. @throws CaseError for one that this version does not have
template <class T>
std::unique_ptr<Refiller<T>> make_refiller(Refill formula, const Domain& domain,
                                           const BlockPartition& partition, const PopulationLayout& layout,
                                           Communicator& communicator);

}  // namespace copepod::fluid
