
#include <gtest/gtest.h>

#include "config/load_case.hpp"
#include "config/setups.hpp"
#include "geometry/contact_time.hpp"

namespace copepod::coupler {
namespace {

/// A sphere of 1 mm in an empty box of 1 cm.
LoadedCase falling(const std::vector<std::string>& overrides = {}) {
  const std::string text =
      "{case: drop, step_s: 1.0e-5, fluid: {solver: vacuum, cell_size_m: 1.0e-3, domain_cells: [10, 10, 10]},\n"
      "bodies: [{name: ball, radius_m: 1.0e-3, mass_kg: 1.0e-5, position_m: [5.0e-3, 5.0e-3, 5.0e-3]}],\n"
      "gravity_m_per_s2: [0, 0, -9.81], contact: {}, run: {steps: 10}}";
  return load_case_text(text, "drop.yaml", overrides);
}

BodySetup setup_of(const LoadedCase& loaded) { return make_body_setup(loaded.content, loaded.assembly); }

std::string error_of(const std::vector<std::string>& overrides) {
  try {
    falling(overrides);
  } catch (const CaseInvalid& invalid) {
    return invalid.lines().front();
  }
  return {};
}

TEST(ContactSetup, LeavesContactsOutOfACaseWithoutThem) {
  const BodySetup setup = setup_of(falling({"contact=null"}));
  EXPECT_EQ(setup.contact.stiffness_N_per_m, 0.0);
  EXPECT_TRUE(setup.walls.empty());
}

TEST(ContactSetup, WarnsOfFacesThatAreNoWallsForBodies) {
  const auto warnings_of = [](const std::vector<std::string>& overrides) {
    std::string text;
    for (const std::string& warning : falling(overrides).warnings) text += warning;
    return text;
  };
  EXPECT_EQ(warnings_of({}), "");
  EXPECT_EQ(warnings_of({"fluid.boundaries={x: periodic, y: free_slip}"}), "");
  EXPECT_NE(
      warnings_of({"fluid.boundaries={x: {low: {pressure_Pa: 0}, high: {velocity_m_per_s: [1, 0, 0]}}}"})
          .find("leaves out fluid.boundaries.x.low, fluid.boundaries.x.high (there is no wall for bodies in solver: "
                "vacuum). They pass through."),
      std::string::npos);
  EXPECT_NE(warnings_of({"fluid.solver=stokes", "fluid.density_kg_per_m3=1000",
                         "fluid.kinematic_viscosity_m2_per_s=1.0e-6", "fluid.no_slip_plane=z_low"})
                .find("fluid.boundaries.y.high, fluid.boundaries.z.high (there is"),
            std::string::npos);
}

TEST(ContactSetup, KeepsTheOverlapOfAnImpactSmall) {
  const BodySetup setup = setup_of(falling());
  // From 1 cm: u² = 2 g h; the overlap of a sphere on a wall is u √(m/k).
  const double overlap_m = std::sqrt(2.0 * 9.81 * 0.01 * 1e-5 / setup.contact.stiffness_N_per_m);
  EXPECT_LT(overlap_m, 1e-5);
  EXPECT_GT(overlap_m, 0.5e-5);
  EXPECT_GT(contact_substeps(setup), 1.0);
  EXPECT_EQ(setup.contact.restitution, 0.9);
  EXPECT_EQ(setup.contact.friction, 0.3);
}

TEST(ContactSetup, IsAsStiffAsStepsWithoutSubstepsAllow) {
  const LoadedCase loaded = falling({"step_s=1e-9"});
  const BodySetup setup = setup_of(loaded);
  EXPECT_EQ(contact_substeps(setup), 1.0);
  EXPECT_NEAR(shortest_contact_s(setup.contact.stiffness_N_per_m, 2e5), 40e-9, 1e-15);
  EXPECT_EQ(setup_of(falling({"contact.stiffness_N_per_m=3"})).contact.stiffness_N_per_m, 3.0);
}

TEST(ContactSetup, HasAWallAtEveryFaceThatBodiesMeet) {
  const BodySetup setup =
      setup_of(falling({"fluid.boundaries={x: periodic, y: {low: free_slip, high: {velocity_m_per_s: [1, 0, 0]}},"
                        " z: {low: no_slip, high: {pressure_Pa: 0}}}"}));
  ASSERT_EQ(setup.walls.size(), 3U);
  EXPECT_EQ(setup.walls[0].normal, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(setup.walls[0].friction, 0.0);
  EXPECT_TRUE(setup.walls[1].point_m.isApprox(Eigen::Vector3d(0, 0.01, 0)));
  EXPECT_EQ(setup.walls[1].normal, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(setup.walls[1].velocity_m_per_s, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(setup.walls[1].friction, 0.3);
  EXPECT_EQ(setup.walls[2].normal, Eigen::Vector3d(0, 0, 1));
  const BodySetup slippery = setup_of(falling({"contact.wall_friction=0", "fluid.boundaries.y=free_slip"}));
  for (const WallSpecification& wall : slippery.walls) EXPECT_EQ(wall.friction, 0.0);
  EXPECT_EQ(slippery.contact.friction, 0.3);
  EXPECT_EQ(setup_of(falling({"contact.friction=0", "contact.wall_friction=0.7"})).walls[0].friction, 0.7);
  EXPECT_EQ(setup_of(falling({"fluid.boundaries.x={velocity_m_per_s: [1, 0, 0]}"})).walls.size(), 4U) << "an inlet";
}

TEST(ContactSetup, RefusesWhatCannotBe) {
  EXPECT_NE(error_of({"contact.restitution=0.01"}).find("Use a number between 0.05 and 1"), std::string::npos);
  EXPECT_NE(error_of({"contact.stiffness_N_per_m=1e20"}).find("substeps in every step"), std::string::npos);
  EXPECT_NE(error_of({"bodies.0.position_m=[5.0e-3, 5.0e-3, 0.9e-3]"}).find("'ball' reaches 100 µm into a wall"),
            std::string::npos);
  EXPECT_EQ(falling({"contact.stiffness_N_per_m=0.01"}).warnings.size(), 1U) << "soft contacts";
}

TEST(ContactSetup, LetsTheFluidAcceptBodiesThatReachBeyondFaces) {
  const LoadedCase loaded = falling();
  EXPECT_EQ(make_fluid_setup(loaded.content, loaded.assembly, "").wall_overlap_m, 0.25e-3);
  const LoadedCase without = falling({"contact=null"});
  EXPECT_EQ(make_fluid_setup(without.content, without.assembly, "").wall_overlap_m, 0.0);
}

}  // namespace
}  // namespace copepod::coupler
