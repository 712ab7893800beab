#include <string>

#include <gtest/gtest.h>

#include "lattice_boltzmann/output/fields.hpp"

namespace copepod::fluid {
namespace {

TEST(Xdmf, NamesGroupsByTheirStepWithNineDigits) {
  EXPECT_EQ(group_of_step(1000), "step_000001000");
  EXPECT_EQ(step_of_group("step_000001000"), 1000);
  EXPECT_EQ(step_of_group("mean"), -1);
}

XdmfGrid grid(const std::string& group) {
  return {group, "fields/" + group + ".h5", {{0, 0, 0}, {4, 5, 6}}, {"density_kg_per_m3", "velocity_m_per_s", "body"}};
}

TEST(Xdmf, PutsSnapshotsIntoACollectionWithTheirTimes) {
  const std::string text = xdmf_text(1e-6, 0.5, {grid("step_000000002"), grid("step_000000004")});
  const std::size_t collection = text.find("<Grid Name='snapshots'");
  const std::size_t first = text.find("<Time Value='1'/>");
  const std::size_t second = text.find("<Time Value='2'/>");
  ASSERT_NE(second, std::string::npos);
  EXPECT_LT(collection, first);
  EXPECT_LT(first, second);
  EXPECT_NE(text.find("Dimensions='7 6 5'"), std::string::npos) << "nodes, z first";
  EXPECT_NE(text.find("Dimensions='6 5 4 3'"), std::string::npos) << "velocities, z first";
  EXPECT_NE(text.find("fields/step_000000004.h5:/step_000000004/body"), std::string::npos);
  EXPECT_EQ(text.find("vorticity"), std::string::npos) << "is not in the file";
}

TEST(Xdmf, DescribesTheMeanAsOneGridWithoutATime) {
  const std::string text = xdmf_text(1e-6, 0.5, {grid("mean")});
  EXPECT_NE(text.find("<Grid Name='mean'"), std::string::npos);
  EXPECT_EQ(text.find("Collection"), std::string::npos);
  EXPECT_EQ(text.find("<Time"), std::string::npos);
}

TEST(Xdmf, PlacesARegionInTheDomain) {
  const XdmfGrid slice{"mean", "fields/mean.h5", {{1, 2, 3}, {4, 3, 8}}, {"pressure_Pa"}};
  const std::string text = xdmf_text(0.5, 1.0, {slice});
  EXPECT_NE(text.find(">1.5 1 0.5<"), std::string::npos) << "origin, z first";
  EXPECT_NE(text.find("Dimensions='5 1 3'"), std::string::npos) << "cells, z first";
}

}  // namespace
}  // namespace copepod::fluid
