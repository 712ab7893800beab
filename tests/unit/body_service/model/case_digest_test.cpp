#include "model/case_digest.hpp"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "body_cases.hpp"

namespace copepod::body {
namespace {

BodySetup two_beads() {
  BodySetup setup = setup_of({bead("a", {0, 0, 0}), bead("b", {0, 0, 2e-5})}, 1e-9);
  setup.springs.emplace_back();
  setup.springs[0].body_B = 1;
  return setup;
}

TEST(CaseDigest, ChangesWithEverythingThatDecidesTheMotion) {
  const std::vector<std::function<void(BodySetup&)>> changes = {
      [](auto& s) { s.step_s *= 2; },
      [](auto& s) { s.integrator = Integrator::semi_implicit_euler; },
      [](auto& s) { s.gravity_m_per_s2[0] = 1; },
      [](auto& s) { s.fluid_density_kg_per_m3 = 1; },
      [](auto& s) { s.bodies[1].name.push_back('c'); },
      [](auto& s) { s.bodies[1].mass_kg *= 2; },
      [](auto& s) { s.bodies[1].shape.radius_m *= 2; },
      [](auto& s) {
        s.bodies[1].shape = {ShapeKind::capsule, s.bodies[1].shape.radius_m, 1.0};
      },
      [](auto& s) { s.bodies[1].motion = MotionKind::fixed; },
      [](auto& s) { s.bodies.pop_back(); },
      [](auto& s) { s.springs[0].stiffness_N_per_m = 1; },
      [](auto& s) { s.springs[0].damping_N_s_per_m = 1; },
      [](auto& s) { s.springs[0].rest_length_m = 1; },
      [](auto& s) { s.springs[0].anchor_A_m[2] = 1; },
      [](auto& s) { s.springs[0].anchor_B_m[2] = 1; },
      [](auto& s) { s.springs.clear(); },
  };
  const std::uint64_t original = case_digest(two_beads());
  EXPECT_EQ(case_digest(two_beads()), original);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    BodySetup changed = two_beads();
    changes[i](changed);
    EXPECT_NE(case_digest(changed), original) << "change " << i;
  }
}

TEST(StateDigest, SeesASingleBitOfEveryPartOfTheState) {
  MotionState state;
  state.resize(2);
  for (auto* matrix : {&state.position_m, &state.velocity_m_per_s, &state.angular_momentum_N_m_s}) {
    matrix->setOnes();
  }
  state.orientation_wxyz.setOnes();
  const std::uint64_t original = state_digest(7, state);
  EXPECT_NE(state_digest(8, state), original);
  for (double* number : {&state.position_m(2, 1), &state.orientation_wxyz(3, 1),
                         &state.velocity_m_per_s(0, 0), &state.angular_momentum_N_m_s(1, 1)}) {
    *number = std::nextafter(1.0, 2.0);
    EXPECT_NE(state_digest(7, state), original);
    *number = 1.0;
  }
  EXPECT_EQ(state_digest(7, state), original);
}

}  // namespace
}  // namespace copepod::body
