// Joints whose motion is given; docs/theory_bodies.md, (B30).
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double drive_step_s = 1e-6;
constexpr double omega_per_s = 2e3;  // a period of 3142 steps

ActuatorSpecification motion_of(int joint) {
  ActuatorSpecification actuator;
  actuator.kind = ActuatorKind::joint_motion;
  actuator.joint = joint;
  return actuator;
}

/// Drives actuator 0 by amplitude · sin ωt, at the nodes of a step.
std::function<void(AppliedLoads&)> sinusoid(double amplitude) {
  return [amplitude](AppliedLoads& applied) {
    const auto n = static_cast<double>(applied.hydrodynamic.step);
    for (int node = 0; node < 3; ++node)
      applied.actuation(0, node) = amplitude * std::sin(omega_per_s * drive_step_s * (n + 0.5 * node));
  };
}

double sine_after(std::int64_t steps) { return std::sin(omega_per_s * drive_step_s * static_cast<double>(steps)); }
double cosine_after(std::int64_t steps) { return std::cos(omega_per_s * drive_step_s * static_cast<double>(steps)); }

/// Of a velocity: the parabola's slope at the end of a step is off by h² s'''/12.
constexpr double of_a_velocity = omega_per_s * omega_per_s * drive_step_s * drive_step_s;

BodySetup driven(BodySetup setup) {
  setup.actuators = {motion_of(0)};
  return setup;
}

TEST(DrivenRod, HasTheLengthAndTheRateThatAreGivenAndPushesBothBodiesAlike) {
  BodySetup setup = driven(setup_of({bead("a", {0, 0, 0}), bead("b", {2e-5, 0, 0})}, drive_step_s));
  setup.joints = {{JointKind::distance, 0, 1}};
  RigidBodySolver solver(setup);
  for (const std::int64_t steps : {1, 400, 1600}) {
    Kinematics now;
    solver.kinematics(now);
    const Kinematics end = advance(solver, steps - now.step, sinusoid(3e-6), 1);
    const double length_m = 2e-5 + 3e-6 * sine_after(steps);
    EXPECT_NEAR((end.position_m.col(1) - end.position_m.col(0)).norm(), length_m, 1e-15 * length_m) << steps;
    EXPECT_NEAR(end.position_m(0, 0) + end.position_m(0, 1), 2e-5, 1e-18) << steps;
    const double rate = 3e-6 * omega_per_s * cosine_after(steps);
    EXPECT_NEAR(end.velocity_m_per_s(0, 1), 0.5 * rate, of_a_velocity * 3e-6 * omega_per_s) << steps;
    EXPECT_NEAR(end.velocity_m_per_s(0, 0), -0.5 * rate, of_a_velocity * 3e-6 * omega_per_s) << steps;
  }
}

TEST(DrivenHinge, TurnsItsFirstBodyByTheAngleThatIsGiven) {
  for (const double sign : {1.0, -1.0}) {
    BodySetup setup = driven(setup_of({capsule("arm", {0, 0, -8e-6})}, drive_step_s));
    setup.joints = {{JointKind::hinge, 0, -1, {0, 0, 8e-6}, {0, 0, 0}, {0, sign, 0}}};
    RigidBodySolver solver(setup);
    const Kinematics end = advance(solver, 700, sinusoid(1.2), 1);
    const double angle = sign * 1.2 * sine_after(700);
    const Eigen::Vector4d turned = rotated({0, angle, 0}, {1, 0, 0, 0});
    EXPECT_LT((end.orientation_wxyz.col(0) - turned).norm(), 1e-14);
    EXPECT_LT((end.position_m.col(0) - Eigen::Vector3d(-8e-6 * std::sin(angle), 0, -8e-6 * std::cos(angle))).norm(),
              1e-19);
    const double rate = sign * 1.2 * omega_per_s * cosine_after(700);
    EXPECT_NEAR(end.angular_velocity_rad_per_s(1, 0), rate, of_a_velocity * 1.2 * omega_per_s);
  }
}

// 0.08 rad in the first step, from rest: Newton's method begins with less than a digit.
TEST(DrivenHinge, StaysClosedInStepsOfAFortiethOfAPeriod) {
  BodySetup setup = driven(setup_of({bead("bob", {2e-5, 0, 0})}, drive_step_s));
  setup.joints = {{JointKind::hinge, 0, -1, {-2e-5, 0, 0}, {0, 0, 0}, {0, 1, 0}}};
  RigidBodySolver solver(setup);
  const auto angle = [](double steps) { return 0.5 * std::sin(2.0 * std::numbers::pi * steps / 40.0); };
  const auto drive = [&](AppliedLoads& applied) {
    for (int node = 0; node < 3; ++node)
      applied.actuation(0, node) = angle(static_cast<double>(applied.hydrodynamic.step) + 0.5 * node);
  };
  for (const std::int64_t steps : {1, 10, 33}) {
    Kinematics now;
    solver.kinematics(now);
    const Kinematics end = advance(solver, steps - now.step, drive, 1);
    const double turned = angle(static_cast<double>(steps));
    const Eigen::Vector3d expected_m(2e-5 * std::cos(turned), 0, -2e-5 * std::sin(turned));
    EXPECT_LT((end.position_m.col(0) - expected_m).norm(), 1e-18) << steps;
  }
}

TEST(DrivenHinge, BetweenFreeBodiesGivesTheWholeNeitherMomentum) {
  BodySetup setup = driven(setup_of({capsule("a", {0, 0, 8e-6}), capsule("b", {0, 0, -8e-6})}, drive_step_s));
  setup.joints = {{JointKind::hinge, 0, 1, {0, 0, -8e-6}, {0, 0, 8e-6}, {1, 0, 0}}};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, 700, sinusoid(0.8), 1);
  const Eigen::Vector3d up_a = z_axis(end.orientation_wxyz.col(0));
  const Eigen::Vector3d up_b = z_axis(end.orientation_wxyz.col(1));
  EXPECT_NEAR(std::asin(up_b.cross(up_a).x()), 0.8 * sine_after(700), 1e-13);
  EXPECT_NEAR(up_a.y(), -up_b.y(), 1e-13) << "by symmetry each turns by half of the angle";
  EXPECT_LT(end.velocity_m_per_s.rowwise().sum().norm(), 1e-12 * end.velocity_m_per_s.norm());
}

TEST(DrivenSlider, MovesAlongAnAxisThatTurnsWithTheOtherBody) {
  BodySetup setup = driven(setup_of({bead("a", {0, 0, 1e-5}), bead("b", {0, 0, 0})}, drive_step_s));
  setup.joints = {{JointKind::slider, 0, 1, {0, 0, -1e-5}, {0, 0, 0}, {0, 0.6, 0.8}}};
  for (auto& body : setup.bodies) body.angular_velocity_rad_per_s = {300, 0, 0};
  setup.bodies[0].velocity_m_per_s = {0, -300 * 1e-5, 0};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, 500, sinusoid(2e-6), 1);
  const Eigen::Matrix3d R_WB = rotation_matrix(end.orientation_wxyz.col(1));
  EXPECT_GT(std::abs(R_WB(1, 2)), 0.05) << "both have turned";
  const Eigen::Vector3d apart_m = R_WB.transpose() * (end.position_m.col(0) - end.position_m.col(1));
  const Eigen::Vector3d expected_m =
      Eigen::Vector3d(0, 0, 1e-5) + 2e-6 * sine_after(500) * Eigen::Vector3d(0, 0.6, 0.8);
  EXPECT_LT((apart_m - expected_m).norm(), 1e-18);
  EXPECT_LT((end.orientation_wxyz.col(0) - end.orientation_wxyz.col(1)).norm(), 1e-13);
}

/// Of an island with a driven and a free joint, beside bodies that may touch.
BodySetup swimmer_with_contacts() {
  BodySetup setup = driven(setup_of(
      {capsule("a", {0, 0, 0}), capsule("b", {0, 0, 1.5e-5}), bead("c", {0, 0, 3e-5}), bead("d", {0, -8.1e-6, 3e-5})},
      drive_step_s));
  setup.joints = {{JointKind::hinge, 1, 0, {0, 0, -8e-6}, {0, 0, 7e-6}, {1, 0, 0}},
                  {JointKind::ball, 2, 1, {0, 0, -6e-6}, {0, 0, 9e-6}}};
  setup.contact = {0.5, 0.7, 0.2};
  return setup;
}

TEST(DrivenJoints, ResumeWithTheSameBitsBetweenContacts) {
  const std::string path = testing::TempDir() + "driven.state";
  RigidBodySolver whole(swimmer_with_contacts());
  advance(whole, 200, sinusoid(0.4), 1);
  whole.save(path);
  const Kinematics end = advance(whole, 200, sinusoid(0.4), 1);
  RigidBodySolver resumed(swimmer_with_contacts());
  resumed.restore(path);
  advance(resumed, 200, sinusoid(0.4), 1);
  EXPECT_EQ(resumed.summarise().digest, whole.summarise().digest);
  const Eigen::Vector3d up =
      z_axis(end.orientation_wxyz.col(0)).cross(Eigen::Vector3d(z_axis(end.orientation_wxyz.col(1))));
  EXPECT_NEAR(std::asin(up.x()), 0.4 * sine_after(400), 1e-12) << "substeps keep the motion";
  EXPECT_LT(end.position_m(1, 3), -8.12e-6) << "the other bead was pushed";
}

std::string refusal_of_a_drive(const std::function<void(BodySetup&)>& change) {
  BodySetup setup = driven(setup_of({bead("a", {0, 0, 0}), bead("b", {2e-5, 0, 0})}, drive_step_s));
  setup.joints = {{JointKind::distance, 0, 1}};
  change(setup);
  return reason_of<CaseError>([&] { const RigidBodySolver solver(setup); });
}

TEST(DrivenJoints, RefuseWhatCannotBeDriven) {
  EXPECT_TRUE(contains(refusal_of_a_drive([](auto& it) { it.actuators[0].joint = 1; }), "Correct the index"));
  EXPECT_TRUE(contains(refusal_of_a_drive([](auto& it) { it.actuators[0].joint = -1; }), "Correct the index"));
  EXPECT_TRUE(contains(refusal_of_a_drive([](auto& it) { it.actuators.push_back(motion_of(0)); }), "another actuator"));
  EXPECT_TRUE(
      contains(refusal_of_a_drive([](auto& it) { it.integrator = Integrator::semi_implicit_euler; }), "runge_kutta_4"));
  EXPECT_TRUE(contains(refusal_of_a_drive([](auto& it) {
                         it.joints = {{JointKind::ball, 0, 1, {1e-5, 0, 0}, {-1e-5, 0, 0}}};
                       }),
                       "no single motion"));
}

}  // namespace
}  // namespace copepod::body
