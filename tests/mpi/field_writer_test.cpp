#include <array>
#include <fstream>
#include <iterator>
#include <tuple>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "files/hdf5_file.hpp"
#include "lattice_boltzmann/output/field_output.hpp"
#include "storage_case.hpp"

namespace copepod::fluid {
namespace {

/// 8 × 6 × 5 cells, of which the lower half along x and y is computed.
FluidSetup quarter_domain() {
  FluidSetup setup;
  setup.domain_cells = {8, 6, 5};
  setup.symmetry_planes = {true, true, false};
  setup.cell_size_m = 1e-6;
  setup.step_s = 2e-10;
  return setup;
}

class Fields : public testing::Test {
 protected:
  Fields() {
    setup_.fields.directory = folder_.path();
    setup_.fields.mean_start = 10;
    setup_.fields.mean_stop = 20;
  }

  SolverContext context_;
  MpiCommunicator ranks_{context_};
  SharedFolder folder_{ranks_};
  FluidSetup setup_ = quarter_domain();
  FieldBlock block_ = numbered_fields(BlockPartition({4, 3, 5}, ranks_.size()).block(ranks_.rank()));
  std::string path_ = folder_.path() + "/fields.h5";
};

TEST(OnEveryRank, TellsTheReasonOfTheLowestFailingRankAndCutsNoCharacterInTwo) {
  SolverContext context;
  MpiCommunicator ranks{context};
  std::string reason = "of rank " + std::to_string(ranks.rank()) + ": ";
  while (reason.size() < 4000) reason += "é…";
  std::string told;
  try {
    on_every_rank(ranks, [&] {
      if (ranks.rank() > 0 || ranks.size() == 1) throw std::runtime_error(reason);
    });
  } catch (const StorageError& error) {
    told = error.what();
  }
  ASSERT_GT(told.size(), 1000U);
  EXPECT_TRUE(told.starts_with(ranks.size() == 1 ? "of rank 0" : "of rank 1")) << told;
  EXPECT_TRUE(told.ends_with("é") || told.ends_with("…")) << told;
}

TEST_F(Fields, CoverTheWholeDomainWithMirroredVelocities) {
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(1000, block_);
  Hdf5File file(path_, Hdf5File::Access::read, context_);
  std::array<double, 5 * 6 * 8> density{};
  std::array<double, 5 * 6 * 8 * 3> velocity{};
  std::array<std::int32_t, 5 * 6 * 8> body{};
  file.read("step_000001000/density_kg_per_m3", {0, 0, 0}, {5, 6, 8}, density.data());
  file.read("step_000001000/velocity_m_per_s", {0, 0, 0, 0}, {5, 6, 8, 3}, velocity.data());
  file.read("step_000001000/body", {0, 0, 0}, {5, 6, 8}, body.data());
  std::size_t cell = 0;
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x, ++cell) {
        const int computed_x = x < 4 ? x : 7 - x;
        const int computed_y = y < 3 ? y : 5 - y;
        ASSERT_EQ(density[cell], 1000 + 10000 * computed_x + 100 * computed_y + z);
        ASSERT_EQ(velocity[3 * cell], (x < 4 ? 1 : -1) * (computed_x + 0.5));
        ASSERT_EQ(velocity[3 * cell + 1], (y < 3 ? 1 : -1) * (computed_y + 0.5));
        ASSERT_EQ(velocity[3 * cell + 2], z + 0.5);
        ASSERT_EQ(body[cell], computed_x % 2);
      }
}

TEST_F(Fields, KnowTheirStepTimeAndUnits) {
  FieldWriter writer(setup_.fields, setup_, ranks_);
  writer.write_snapshot(1000, block_);
  writer.write_mean(10, block_);
  Hdf5File file(path_, Hdf5File::Access::read, context_);
  EXPECT_EQ(file.names(), (std::vector<std::string>{"mean", "step_000001000"}));
  EXPECT_EQ(file.read_attribute<std::int64_t>("step_000001000", "step"), 1000);
  EXPECT_EQ(file.read_attribute<double>("step_000001000", "time_s"), 1000 * 2e-10);
  EXPECT_EQ(file.read_attribute<std::int64_t>("step_000001000", "step_of_bodies"), 999);
  EXPECT_EQ(file.read_attribute<double>("step_000001000", "cell_size_m"), 1e-6);
  EXPECT_EQ(file.read_attribute<double>("step_000001000", "step_s"), 2e-10);
  EXPECT_EQ(file.read_attribute<std::int64_t>("mean", "samples"), 10);
  EXPECT_EQ(file.read_attribute<std::int64_t>("mean", "mean_stop"), 20);
}

TEST_F(Fields, GoOnInTheSameFileAfterARestartAndReplaceARepeatedStep) {
  FieldBlock first = block_;
  for (double& density : first.density_kg_per_m3) density = -1;
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(1, block_);
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(2, first);
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(2, block_);
  Hdf5File file(path_, Hdf5File::Access::read, context_);
  EXPECT_EQ(file.names(), (std::vector<std::string>{"step_000000001", "step_000000002"}));
  std::array<double, 1> density{};
  file.read("step_000000002/density_kg_per_m3", {0, 0, 0}, {1, 1, 1}, density.data());
  EXPECT_EQ(density[0], 1000);
}

TEST_F(Fields, AreReadAgainAsTheFlowToStartWith) {
  setup_.density_kg_per_m3 = 1000.0;
  FieldBlock flow = block_;
  for (double& density : flow.density_kg_per_m3) density = 1000.0 + 1e-3 * (density - 1000.0);
  setup_.fields.quantities = {FieldQuantity::velocity, FieldQuantity::density};
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(40, flow);
  setup_.fields.quantities = {FieldQuantity::velocity, FieldQuantity::pressure};
  setup_.fields.compression = 1;
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(7, flow);
  folder_.barrier();
  setup_.initial_flow = {.kind = InitialFlowKind::file, .file = path_};
  for (const auto& [group, step_s, factor] : {std::tuple{"newest", 2e-10, 1.0},
                                              {"step_000000007", 2e-10, 1.0},
                                              {"step_000000040", 1e-10, 0.25},
                                              {"step_000000007", 1e-10, 0.25}}) {
    setup_.initial_flow.group = group;
    setup_.step_s = step_s;
    const FieldBlock read = read_flow(setup_, block_.box, context_);
    EXPECT_EQ(read.velocity_m_per_s, flow.velocity_m_per_s) << group;
    ASSERT_EQ(read.density_kg_per_m3.size(), flow.density_kg_per_m3.size());
    for (std::size_t i = 0; i < read.density_kg_per_m3.size(); ++i)
      ASSERT_NEAR(read.density_kg_per_m3[i], 1000.0 + factor * (flow.density_kg_per_m3[i] - 1000.0), 1e-9) << group;
  }
}

TEST_F(Fields, DescribeEverySnapshotToParaView) {
  FieldWriter writer(setup_.fields, setup_, ranks_);
  writer.write_snapshot(1, block_);
  writer.write_snapshot(2, block_);
  folder_.barrier();
  std::ifstream file(folder_.path() + "/fields.xdmf");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("fields/step_000000001.h5:/step_000000001/density_kg_per_m3"), std::string::npos);
  EXPECT_NE(text.find("fields/step_000000002.h5:/step_000000002/velocity_m_per_s"), std::string::npos);
}

TEST_F(Fields, OfAnotherRegionThanBeforeARestartAreDescribedAsTheyAre) {
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(1, block_);
  setup_.fields.region_cells = {1, 3, 0, 0, 4, 5};
  setup_.fields.quantities = {FieldQuantity::vorticity};
  setup_.fields.compression = 1;
  FieldWriter(setup_.fields, setup_, ranks_).write_snapshot(2, block_);
  folder_.barrier();
  std::ifstream file(folder_.path() + "/fields.xdmf");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("Dimensions='5 6 8 3' NumberType='Float' Precision='8' Format='HDF'>"
                      "fields/step_000000001.h5:/step_000000001/velocity_m_per_s"),
            std::string::npos);
  EXPECT_NE(text.find("Dimensions='1 6 2 3' NumberType='Float' Precision='8' Format='HDF'>"
                      "fields/step_000000002.h5:/step_000000002/vorticity_per_s"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() + "/fields/uncompressed"));
}

TEST_F(Fields, HaveTheVorticityAcrossBlocksThatBodiesMakeUnequal) {
  setup_.domain_cells = {24, 6, 6};
  setup_.symmetry_planes = {};
  setup_.bodies.resize(20);
  FieldBlock block;
  block.box = BlockPartition(setup_.domain_cells, ranks_.size(), setup_.bodies.size()).block(ranks_.rank());
  EXPECT_NE(ranks_.size() > 1, block.box == BlockPartition(setup_.domain_cells, ranks_.size()).block(ranks_.rank()));
  for_each_cell(block.box, [&](const Cell& cell) {
    block.velocity_m_per_s.insert(block.velocity_m_per_s.end(), {0.0, 3e-6 * static_cast<double>(cell[0]), 0.0});
    block.body.push_back(0);
  });
  const std::vector<double> vorticity = fluid::vorticity(setup_, block, ranks_);
  std::size_t next = 0;
  for_each_cell(block.box, [&](const Cell& cell) {
    EXPECT_TRUE(cell[0] == 0 || cell[0] == 23 || std::abs(vorticity[next + 2] - 3.0) < 1e-12) << cell[0];
    next += 3;
  });
}

TEST_F(Fields, RefuseARegionWithoutCells) {
  setup_.fields.region_cells = {8, 9, 0, 0, 0, 0};
  EXPECT_THROW(FieldWriter(setup_.fields, setup_, ranks_), CaseError);
}

TEST_F(Fields, ReportAFolderThatIsNotThereOnEveryRank) {
  setup_.fields.directory = folder_.path() + "/missing";
  FieldWriter writer(setup_.fields, setup_, ranks_);
  EXPECT_THROW(writer.write_snapshot(1, block_), StorageError);
}

}  // namespace
}  // namespace copepod::fluid
