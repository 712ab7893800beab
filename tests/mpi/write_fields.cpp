#include <cstdlib>
#include <string>

#include "lattice_boltzmann/output/field_output.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/mpi_communicator.hpp"
#include "storage_case.hpp"

/// write_fields FOLDER SNAPSHOTS SCALE [selected]: snapshots and a mean of numbered_fields on a quarter of 8·SCALE ×
/// 6·SCALE × 5·SCALE cells, for the tests that read the files with h5py and VTK. `selected`: all
/// quantities in a region, compressed.
int main(int argc, char** argv) {
  using namespace copepod::fluid;
  using copepod::FieldQuantity;
  MpiSession session;
  if (argc < 4 || argc > 5) return session.finish(2);
  const std::int64_t scale = std::atoll(argv[3]);
  copepod::FluidSetup setup;
  setup.domain_cells = {8 * scale, 6 * scale, 5 * scale};
  setup.symmetry_planes = {true, true, false};
  setup.cell_size_m = 1e-6;
  setup.step_s = 2e-10;
  setup.density_kg_per_m3 = 1000.0;
  setup.fields.directory = argv[1];
  if (argc == 5) {
    setup.fields.quantities = {FieldQuantity::pressure, FieldQuantity::velocity, FieldQuantity::vorticity};
    setup.fields.region_cells = {2, 7, 4, 5, 0, 0};
    setup.fields.compression = 1;
  }
  const BlockPartition partition({4 * scale, 3 * scale, 5 * scale}, session.ranks().size());
  const FieldBlock block = numbered_fields(partition.block(session.ranks().rank()));
  FieldWriter writer(setup.fields, setup, session.ranks());
  MeanField mean;
  for (int snapshot = 1; snapshot <= std::atoi(argv[2]); ++snapshot) {
    writer.write_snapshot(1000 * snapshot, block);
    mean.add(block);
  }
  writer.write_mean(mean.samples(), mean.mean());
  return session.finish(0);
}
