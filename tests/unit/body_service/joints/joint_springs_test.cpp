// Springs and dampers of hinges and sliders; docs/theory_bodies.md, (B33).
#include <cmath>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double sprung_step_s = 1e-6;
constexpr std::int64_t sprung_steps = 1500;
constexpr double sprung_time_s = 1.5e-3;

/// Place of m ẍ = −k (x − rest) − c ẋ that starts at rest at 0.
double relaxed_by(double mass, double stiffness, double damping, double rest, double time_s) {
  const double decay = 0.5 * damping / mass;
  const double frequency = std::sqrt(stiffness / mass - decay * decay);
  return rest * (1.0 - std::exp(-decay * time_s) *
                           (std::cos(frequency * time_s) + decay / frequency * std::sin(frequency * time_s)));
}

JointSpecification sprung(JointKind kind, int body_B, double stiffness, double damping, double rest,
                          const Eigen::Vector3d& axis) {
  JointSpecification joint{kind, 0, body_B};
  joint.axis = axis;
  joint.stiffness = stiffness;
  joint.damping = damping;
  joint.rest = rest;
  return joint;
}

TEST(JointSpring, OfAHingeIsATorsionPendulumWhoseHeavyEndIsTheWorld) {
  BodySetup setup = setup_of({capsule("arm", {0, 0, 0})}, sprung_step_s);
  const double inertia_kg_m2 = inertia_tensor_kg_m2(setup.bodies[0].shape, setup.bodies[0].mass_kg)(0, 0);
  const double stiffness = 4e6 * inertia_kg_m2;  // half a turn of the phase in 1570 steps
  const double damping = 300 * inertia_kg_m2;
  setup.joints = {sprung(JointKind::hinge, -1, stiffness, damping, 1.2, {0, 1, 0})};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, sprung_steps);
  const double angle = relaxed_by(inertia_kg_m2, stiffness, damping, 1.2, sprung_time_s);
  EXPECT_GT(angle, 1.2);
  EXPECT_LT((end.orientation_wxyz.col(0) - rotated({0, angle, 0}, {1, 0, 0, 0})).norm(), 1e-11);
}

TEST(JointSpring, OfASliderBetweenTwoBodiesMovesTheirReducedMass) {
  BodySetup setup = setup_of({bead("a", {2e-5, 0, 0}), bead("b", {0, 0, 0})}, sprung_step_s);
  const double reduced_kg = 0.5 * setup.bodies[0].mass_kg;
  setup.joints = {sprung(JointKind::slider, 1, 4e6 * reduced_kg, 300 * reduced_kg, -2e-6, {1, 0, 0})};
  setup.joints[0].anchor_A_m = {-2e-5, 0, 0};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, sprung_steps);
  const double moved_m = relaxed_by(reduced_kg, 4e6 * reduced_kg, 300 * reduced_kg, -2e-6, sprung_time_s);
  EXPECT_NEAR(end.position_m(0, 0), 2e-5 + 0.5 * moved_m, 1e-11 * std::abs(moved_m));
  EXPECT_NEAR(end.position_m(0, 1), -0.5 * moved_m, 1e-11 * std::abs(moved_m));
}

TEST(JointSpring, OfASliderToTheWorldIsAnOscillatorOnARail) {
  BodySetup setup = setup_of({bead("a", {0, 0, 0})}, sprung_step_s);
  const double mass_kg = setup.bodies[0].mass_kg;
  const Eigen::Vector3d axis(0.6, 0, 0.8);
  setup.joints = {sprung(JointKind::slider, -1, 4e6 * mass_kg, 300 * mass_kg, -2e-6, axis)};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, sprung_steps);
  const double moved_m = relaxed_by(mass_kg, 4e6 * mass_kg, 300 * mass_kg, -2e-6, sprung_time_s);
  EXPECT_LT((end.position_m.col(0) - moved_m * axis).norm(), 1e-11 * std::abs(moved_m));
}

TEST(JointSpring, IsRefusedWhereThereIsNoMotionOrItsNumbersAreNegative) {
  const auto refusal_of_a_spring = [](const JointSpecification& joint) {
    BodySetup setup = setup_of({bead("a", {0, 0, 0})}, sprung_step_s);
    setup.joints = {joint};
    return reason_of<CaseError>([&] { const RigidBodySolver solver(setup); });
  };
  EXPECT_TRUE(contains(refusal_of_a_spring(sprung(JointKind::ball, -1, 1, 0, 0, {0, 0, 1})), "only hinges"));
  EXPECT_TRUE(contains(refusal_of_a_spring(sprung(JointKind::hinge, -1, -1, 0, 0, {0, 0, 1})), "not valid"));
  EXPECT_TRUE(contains(refusal_of_a_spring(sprung(JointKind::hinge, -1, 1, 0, NAN, {0, 0, 1})), "not valid"));
}

}  // namespace
}  // namespace copepod::body
