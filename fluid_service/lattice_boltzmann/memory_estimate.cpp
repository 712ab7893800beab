#include <algorithm>

#include "lattice_boltzmann/lattice_boltzmann.hpp"

namespace copepod::fluid {

namespace {

/// Copies of the fields while they are written [bytes per cell]: those of the step, or the sums and their mean; a
/// derived one; and the largest as it lies in the file. Gradients of velocities, of totals or a flow that is read, take
/// as much.
std::int64_t field_bytes(const FieldOutput& fields, const FlowSampling& flow, bool reads_flow) {
  constexpr std::int64_t number = sizeof(double);
  const bool has_totals = reads_flow || (flow.every_steps > 0 && flow.totals);
  if (fields.every_steps == 0 && fields.mean_stop == 0 && !has_totals) return 0;
  const auto asks_for = [&](FieldQuantity quantity) {
    return std::ranges::find(fields.quantities, quantity) != fields.quantities.end();
  };
  const std::int64_t derived = asks_for(FieldQuantity::vorticity)  ? 3 * number
                               : asks_for(FieldQuantity::pressure) ? number
                                                                   : 0;
  return (fields.mean_stop > 0 ? 2 : 1) * (4 * number + std::int64_t{sizeof(std::int32_t)}) + derived + 3 * number;
}

/// @param cell_bytes  for output
std::int64_t bytes_of_block(const Box& block, const Domain& domain, int number_bytes, std::int64_t cell_bytes) {
  constexpr std::int64_t huge_page = std::int64_t{2} << 20;
  const PopulationLayout layout(block, number_bytes);
  const std::int64_t pages = (layout.values() * number_bytes + huge_page - 1) / huge_page;
  std::int64_t bytes =
      pages * huge_page + layout.cells() * std::int64_t{sizeof(std::int32_t)} + cell_bytes * block.volume();
  for (int axis = 0; axis < 3; ++axis) {
    // Five populations per face cell, sent and received.
    const std::int64_t faces = (block.low[axis] > 0 ? 1 : 0) + (block.high[axis] < domain.cells()[axis] ? 1 : 0);
    bytes += faces * 2 * 5 * number_bytes * (block.volume() / block.extent(axis));
  }
  return bytes;
}

}  // namespace

std::int64_t estimate_lattice_boltzmann_bytes(const FluidSetup& setup, int ranks) {
  const Domain domain(setup, LatticeUnits(setup));
  const BlockPartition partition(domain.cells(), ranks, setup.bodies.size());
  const int number_bytes = setup.precision == Precision::single_precision ? sizeof(float) : sizeof(double);
  const bool writes_fields = setup.fields.every_steps > 0 || setup.fields.mean_stop > 0;
  const bool reads_flow = setup.initial_flow.kind == InitialFlowKind::file;
  const std::int64_t cell_bytes = field_bytes(setup.fields, setup.flow, reads_flow);
  std::int64_t largest = 0;
  for (int rank = 0; rank < ranks; ++rank)
    largest = std::max(largest, bytes_of_block(partition.block(rank), domain, number_bytes, cell_bytes));
  constexpr std::int64_t hdf5_library = std::int64_t{4} << 20;
  return largest + (writes_fields || reads_flow ? hdf5_library : 0);
}

}  // namespace copepod::fluid
