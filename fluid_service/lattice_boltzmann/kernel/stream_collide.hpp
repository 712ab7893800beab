#pragma once

#include <string>

#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {

/// Updates the cells of `region` (indices from the block's low corner) by one step: stream, collide, store.
/// Solid cells are updated like fluid ones: no fluid cell ever reads what they produce, since every link into
/// a solid cell is overwritten before the step (boundary/, bodies/), and the loop stays free of branches.
///
/// Every cell is computed by the same sequence of IEEE operations whether it falls into the vector body or
/// the remainder, and whatever the instruction set: no contraction to fused multiply-adds.
template <class T>
using StreamCollide = void (*)(T* populations, const PopulationLayout& layout, Placement placement,
                               const Box& region, const CollisionConstants<T>& constants, bool has_force);

/// The fastest build of the kernel that this machine can run.
template <class T>
struct KernelChoice {
  StreamCollide<T> update;
  std::string instruction_set;  ///< "avx2" or "baseline"
};

template <class T>
KernelChoice<T> choose_stream_collide();

/// A particular build, for tests and benchmarks; null if this machine cannot run it.
template <class T>
StreamCollide<T> stream_collide_baseline();
template <class T>
StreamCollide<T> stream_collide_avx2();

}  // namespace copepod::fluid
