#include <numbers>

#include <gtest/gtest.h>

#include "config/load_case.hpp"

namespace copepod::coupler {
namespace {

LoadedCase case_of_one(const std::string& swimmer) {
  return load_case_text(
      "case: one\nfluid: {solver: vacuum}\nstep_s: 0.001\nswimmers: [{name: s, center_m: [1, 2, 3], " + swimmer +
          "}]\nrun: {steps: 10}\n",
      "one.yaml", {});
}

const std::string arm = "spring: {stiffness_N_per_m: 5, damping_ratio: 0.5, rest_gap_m: 2}";

TEST(SwimmerSection, PutsAChainIntoARowAroundItsMiddle) {
  const LoadedCase odd = case_of_one(
      "beads: [{name: A, radius_m: 1, mass_kg: 1}, {name: B, radius_m: 2, mass_kg: 4}, "
      "{name: C, shape: capsule, radius_m: 1, length_m: 6, mass_kg: 4}], "
      "arms: [{beads: [B, A], " +
      arm + "}, {beads: [B, C], " + arm + "}]");
  EXPECT_EQ(odd.assembly.bodies[0].position_m, Eigen::Vector3d(1, 2, 3 - 5));
  EXPECT_EQ(odd.assembly.bodies[1].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(odd.assembly.bodies[2].position_m, Eigen::Vector3d(1, 2, 3 + 8));
  EXPECT_EQ(odd.assembly.springs[0].rest_length_m, 5);
  EXPECT_EQ(odd.assembly.springs[1].rest_length_m, 8);
  // γ = 2 D √(m k), m twice the reduced mass
  EXPECT_DOUBLE_EQ(odd.assembly.springs[0].damping_N_s_per_m, std::sqrt(1.6 * 5));
  EXPECT_DOUBLE_EQ(odd.assembly.springs[1].damping_N_s_per_m, std::sqrt(4.0 * 5));
  const LoadedCase even = case_of_one(
      "axis: [1, 0, 0], beads: [{name: A, radius_m: 1, mass_kg: 1}, "
      "{name: B, radius_m: 1, mass_kg: 1}], arms: [{beads: [A, B], " +
      arm + "}]");
  EXPECT_TRUE(even.assembly.bodies[0].position_m.isApprox(Eigen::Vector3d(-1, 2, 3)));
  EXPECT_TRUE(even.assembly.bodies[1].position_m.isApprox(Eigen::Vector3d(3, 2, 3)));
}

const std::string three_arms =
    "beads: [{name: A, radius_m: 1, density_kg_per_m3: 2, position_m: [3, 0, 0]}, "
    "{name: B, radius_m: 1, mass_kg: 1, position_m: [0, 0, 4]}, {name: C, radius_m: 1, mass_kg: 1, "
    "position_m: [0, 0, -4]}], arms: [{beads: [A, B], spring: {stiffness_N_per_m: 5}}, "
    "{beads: [B, C], spring: {stiffness_N_per_m: 5, rest_length_m: 7}, drive: {kind: rest_length, signal: {kind: "
    "sinusoid, amplitude_m: 0.1, period_steps: 400, lag_steps: 10, start_step: 5, stop_step: 900}}}], "
    "bends: [{beads: [A, B, C], stiffness_N_m_per_rad: 1, rest_angle_deg: 90}]";

TEST(SwimmerSection, TakesBeadsInAnyPlaces) {
  // A quarter turn about x takes the swimmer's z axis to −y.
  const LoadedCase loaded =
      case_of_one("orientation_wxyz: [0.7071067811865476, 0.7071067811865476, 0, 0], " + three_arms);
  EXPECT_TRUE(loaded.assembly.bodies[0].position_m.isApprox(Eigen::Vector3d(4, 2, 3)));
  EXPECT_TRUE(loaded.assembly.bodies[1].position_m.isApprox(Eigen::Vector3d(1, -2, 3)));
  EXPECT_DOUBLE_EQ(loaded.assembly.bodies[0].mass_kg, 2 * 4.0 / 3.0 * std::numbers::pi);
  EXPECT_EQ(loaded.assembly.springs[0].rest_length_m, 5);
  EXPECT_EQ(loaded.assembly.springs[1].rest_length_m, 7);
  ASSERT_EQ(loaded.assembly.bends.size(), 1U);
  EXPECT_EQ(loaded.assembly.bends[0].body_B, 1);
  EXPECT_DOUBLE_EQ(loaded.assembly.bends[0].rest_angle_rad, 0.5 * std::numbers::pi);
}

TEST(SwimmerSection, DelaysEverySignalByThePhaseOfTheSwimmer) {
  const Signal plain = case_of_one(three_arms).assembly.drive[0].signal;
  EXPECT_EQ(plain.amplitude, 0.5);
  for (const std::string phase : {"phase_deg: 90", "phase_deg: -270", "phase_rad: 1.5707963267948966"}) {
    const Signal late = case_of_one(phase + ", " + three_arms).assembly.drive[0].signal;
    for (const std::int64_t step : {0, 4, 5, 100, 104, 105, 500, 899, 900, 999, 1000})
      EXPECT_NEAR(value_of(late, step, 0.5), step < 100 ? 0.0 : value_of(plain, step - 100, 0.5), 1e-15) << step;
  }
}

}  // namespace
}  // namespace copepod::coupler
