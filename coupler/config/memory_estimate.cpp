#include "config/memory_estimate.hpp"

#include <algorithm>
#include <array>

namespace copepod::coupler {
namespace {

using Extent = std::array<std::int64_t, 3>;

/// The largest block of a partition, and into how many blocks each axis is cut.
struct Share {
  Extent block;
  Extent cuts{1, 1, 1};
};

constexpr std::int64_t mebibyte = std::int64_t{1} << 20;

// Measured with Debian 12 (docs/results/memory.md).
constexpr std::int64_t fluid_process = 26 * mebibyte;
constexpr std::int64_t body_process = 10 * mebibyte;
constexpr std::int64_t bullet_process = 12 * mebibyte;
constexpr std::int64_t in_process_process = 16 * mebibyte;  // coupler, fluid and bodies in one
constexpr std::int64_t coupler_process = 11 * mebibyte;
constexpr std::int64_t coupler_checkpoints = 1 * mebibyte;
constexpr std::int64_t hdf5_library = 4 * mebibyte;  // of a rank that writes files

constexpr std::int64_t round_up(std::int64_t value, std::int64_t multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

/// The share of the largest rank when the domain is cut once per prime factor of the ranks, where the halo
/// costs least.
Share largest_share(const FluidCase& fluid, int ranks) {
  constexpr Extent face_cost{8, 13,
                             70};  // of a face cell normal to x, y, z (docs/decisions/partition_cost.md)
  Share share;
  for (std::size_t axis = 0; axis < 3; ++axis)
    share.block[axis] = fluid.symmetry_planes[axis] ? fluid.domain_cells[axis] / 2 : fluid.domain_cells[axis];
  // The cost of a face normal to an axis is the block's volume times this.
  const auto cost = [&share, &face_cost](std::size_t axis) {
    return static_cast<double>(face_cost[axis]) / static_cast<double>(share.block[axis]);
  };
  for (int factor = 2; ranks > 1; ++factor) {
    for (; ranks % factor == 0; ranks /= factor) {
      std::size_t cheapest = 0;
      for (std::size_t axis = 1; axis < 3; ++axis) cheapest = cost(axis) < cost(cheapest) ? axis : cheapest;
      share.block[cheapest] = (share.block[cheapest] + factor - 1) / factor;
      share.cuts[cheapest] *= factor;
    }
  }
  return share;
}

/// Buffers for what crosses the faces to other ranks: 5 populations, sent and received.
std::int64_t halo_bytes(const Share& share, std::int64_t number_bytes) {
  const std::int64_t per_face_cell = 5 * 2 * number_bytes;
  std::int64_t bytes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t faces = std::min<std::int64_t>(2, share.cuts[axis] - 1);
    bytes += faces * per_face_cell * share.block[(axis + 1) % 3] * share.block[(axis + 2) % 3];
  }
  return bytes;
}

/// Populations and covering bodies of a block, in the layout of the fluid service (rows along z padded to
/// cache lines).
std::int64_t lattice_bytes(const Extent& block, std::int64_t number_bytes) {
  const std::int64_t lead = 64 / number_bytes;
  const std::int64_t cells = (block[0] + 2) * (block[1] + 2) * round_up(lead + block[2] + 1, lead);
  return round_up(19 * number_bytes * cells, 2 * mebibyte) + 4 * cells;
}

std::int64_t field_bytes(const Extent& block, const OutputCase& output) {
  const std::int64_t copies = output.fields.mean_stop > 0 ? 3 : output.fields.every_steps > 0 ? 2 : 0;
  return copies * 36 * block[0] * block[1] * block[2];
}

std::int64_t file_bytes(const Extent& block, const OutputCase& output) {
  const bool writes_files = wants_fields(output) || output.checkpoint_every_steps > 0;
  return writes_files ? hdf5_library + field_bytes(block, output) : 0;
}

std::int64_t fluid_rank_bytes(const Case& the_case) {
  const FluidCase& fluid = the_case.fluid;
  if (computes_no_cells(fluid.solver)) return fluid_process;
  const Share share = largest_share(fluid, the_case.services.fluid_ranks);
  const std::int64_t number_bytes = fluid.precision == Precision::single_precision ? 4 : 8;
  return fluid_process + lattice_bytes(share.block, number_bytes) + halo_bytes(share, number_bytes) +
         file_bytes(share.block, the_case.output);
}

}  // namespace

MemoryEstimate estimate_memory(const Case& the_case) {
  MemoryEstimate estimate;
  if (the_case.services.transport == in_process_transport) {
    estimate.coupler = in_process_process;
    return estimate;
  }
  estimate.coupler = coupler_process + (the_case.output.checkpoint_every_steps > 0 ? coupler_checkpoints : 0);
  if (the_case.services.fluid_command.empty()) {
    estimate.fluid_ranks = the_case.services.fluid_ranks;
    estimate.fluid_rank = fluid_rank_bytes(the_case);
  }
  if (the_case.services.body_command.empty())
    estimate.body = the_case.body.solver == BodySolverChoice::bullet ? bullet_process : body_process;
  return estimate;
}

}  // namespace copepod::coupler
