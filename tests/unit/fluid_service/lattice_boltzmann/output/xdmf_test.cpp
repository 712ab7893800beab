#include "lattice_boltzmann/output/xdmf.hpp"

#include <string>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

TEST(Xdmf, NamesGroupsByTheirStepWithNineDigits) {
  EXPECT_EQ(group_of_step(1000), "step_000001000");
  EXPECT_EQ(step_of_group("step_000001000"), 1000);
  EXPECT_EQ(step_of_group("mean"), -1);
}

TEST(Xdmf, PutsSnapshotsIntoACollectionAndTheMeanBesideIt) {
  const std::string text = xdmf_text({{4, 5, 6}, 1e-6, 0.5, "fields.h5", {"mean", "step_000000002", "step_000000004"}});
  const std::size_t collection = text.find("<Grid Name='snapshots'");
  const std::size_t first = text.find("<Time Value='1'/>");
  const std::size_t second = text.find("<Time Value='2'/>");
  const std::size_t mean = text.find("<Grid Name='mean'");
  ASSERT_NE(mean, std::string::npos);
  EXPECT_LT(collection, first);
  EXPECT_LT(first, second);
  EXPECT_LT(second, mean);
  EXPECT_NE(text.find("Dimensions='7 6 5'"), std::string::npos) << "nodes, z first";
  EXPECT_NE(text.find("Dimensions='6 5 4 3'"), std::string::npos) << "velocities, z first";
  EXPECT_NE(text.find("fields.h5:/step_000000004/body"), std::string::npos);
}

TEST(Xdmf, HasNoCollectionWithoutSnapshots) {
  EXPECT_EQ(xdmf_text({{4, 5, 6}, 1e-6, 0.5, "fields.h5", {"mean"}}).find("Collection"), std::string::npos);
}

}  // namespace
}  // namespace copepod::fluid
