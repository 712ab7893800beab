#include "mujoco/mujoco_world.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <unistd.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "engine/engine_under_test.hpp"
#include "geometry/contact_time.hpp"
#include "geometry/rotation.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {

MakeEngineWorld engine_under_test() { return make_mujoco_world; }

namespace {

constexpr double half_m = 8e-6;  ///< from the centre of a capsule to its end
constexpr double span_s = 2e-3;  ///< about one period of a link that hangs

/// `links` capsules that hang from the origin by their ends, turned out of the vertical.
BodySetup hanging(const std::vector<double>& angles_rad, JointKind kind) {
  BodySetup setup = setup_of({}, span_s);
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  Eigen::Vector3d top_m = Eigen::Vector3d::Zero();
  for (const double angle_rad : angles_rad) {
    const auto body = static_cast<int>(setup.bodies.size());
    const Eigen::Vector4d q = rotated({0, angle_rad, 0}, {1, 0, 0, 0});
    setup.bodies.push_back(capsule("link " + std::to_string(body), top_m - half_m * z_axis(q)));
    setup.bodies.back().orientation_wxyz = q;
    top_m -= 2.0 * half_m * z_axis(q);
    JointSpecification& joint = setup.joints.emplace_back();
    joint.kind = kind;
    joint.body_A = body;
    joint.body_B = body - 1;
    joint.anchor_A_m = {0, 0, half_m};
    if (body > 0) joint.anchor_B_m = {0, 0, -half_m};
    joint.axis = {0, 1, 0};
  }
  return setup;
}

/// Two capsules in a row that tumble, with a joint of that kind where they meet, which is at rest.
BodySetup tumbling(JointKind kind, bool exchanged = false) {
  BodySetup setup = setup_of({capsule("a", {0, 0, half_m}), capsule("b", {0, 0, -half_m})}, span_s);
  JointSpecification joint{kind, 0, 1, {0, 0, -half_m}, {0, 0, half_m}, {0, 0.6, 0.8}};
  Eigen::Vector3d relative_per_s(0, 0, 0);
  if (kind == JointKind::ball || kind == JointKind::distance) relative_per_s = {2e3, -1e3, 0};
  if (kind == JointKind::hinge) relative_per_s = 2e3 * joint.axis;
  if (kind == JointKind::distance) joint.anchor_A_m = {half_m, 0, -half_m};
  for (BodySpecification& body : setup.bodies) {
    body.angular_velocity_rad_per_s = {2e3, 0, 3e3};
    if (&body == setup.bodies.data()) body.angular_velocity_rad_per_s += relative_per_s;
    body.velocity_m_per_s = body.angular_velocity_rad_per_s.cross(body.position_m);
  }
  if (exchanged) joint = {kind, 1, 0, joint.anchor_B_m, joint.anchor_A_m, joint.axis};
  setup.joints = {joint};
  return setup;
}

double largest_difference_m(const BodySetup& setup, std::int64_t steps) {
  BodySetup fine = setup;
  fine.step_s = span_s / static_cast<double>(steps);
  EngineBodySolver mujoco = engine_solver(fine);
  RigidBodySolver own(fine);
  const auto actuators = static_cast<Eigen::Index>(setup.actuators.size());
  const Kinematics theirs = advance(mujoco, steps, {}, actuators);
  const Kinematics ours = advance(own, steps, {}, actuators);
  return (theirs.position_m - ours.position_m).colwise().norm().maxCoeff();
}

struct Mechanism {
  std::string name;
  BodySetup setup;
  double error;  ///< with 1000 steps [radii]
};

class Mechanisms : public testing::TestWithParam<Mechanism> {};

// Our own solver is of fourth order: exact here.
TEST_P(Mechanisms, MoveAsInOurOwnSolverToFirstOrderInTheStep) {
  const double whole_m = largest_difference_m(GetParam().setup, 1000);
  EXPECT_LT(whole_m, GetParam().error * 4e-6);
  EXPECT_NEAR(whole_m / largest_difference_m(GetParam().setup, 2000), 2.0, 0.3);
}

BodySetup four_bar() {
  BodySetup setup = hanging({0.3, 1.2, 2.8}, JointKind::hinge);
  const BodySpecification& last = setup.bodies.back();
  const Eigen::Vector3d end_m = last.position_m - half_m * z_axis(last.orientation_wxyz);
  setup.joints.push_back({JointKind::hinge, 2, -1, {0, 0, -half_m}, end_m, {0, 1, 0}});
  return setup;
}

BodySetup sprung(JointKind kind, bool exchanged) {
  BodySetup setup = tumbling(kind, exchanged);
  const bool hinge = kind == JointKind::hinge;
  setup.joints[0].stiffness = hinge ? 4e-16 : 4e-6;
  setup.joints[0].damping = hinge ? 1e-20 : 1e-10;
  setup.joints[0].rest = hinge ? 0.5 : 2e-6;
  return setup;
}

INSTANTIATE_TEST_SUITE_P(Of, Mechanisms,
                         testing::Values(Mechanism{"Pendulum", hanging({1.2}, JointKind::hinge), 0.04},
                                         Mechanism{"DoublePendulum", hanging({1.2, 0.4}, JointKind::hinge), 0.08},
                                         Mechanism{"BallChain", hanging({1.2, 0.4, 0.2}, JointKind::ball), 0.08},
                                         Mechanism{"FourBar", four_bar(), 0.08},
                                         Mechanism{"Ball", tumbling(JointKind::ball), 0.2},
                                         Mechanism{"BallExchanged", tumbling(JointKind::ball, true), 0.2},
                                         Mechanism{"Hinge", tumbling(JointKind::hinge), 0.2},
                                         Mechanism{"HingeSpring", sprung(JointKind::hinge, false), 0.2},
                                         Mechanism{"HingeSpringExchanged", sprung(JointKind::hinge, true), 0.2},
                                         Mechanism{"SliderSpring", sprung(JointKind::slider, false), 0.2},
                                         Mechanism{"SliderSpringExchanged", sprung(JointKind::slider, true), 0.2},
                                         Mechanism{"Fixed", tumbling(JointKind::fixed), 0.2},
                                         Mechanism{"Rod", tumbling(JointKind::distance), 0.8}),
                         [](const auto& info) { return info.param.name; });

TEST(MujocoWorld, StopsHingesAndSlidersAtTheirLimitsAsOurOwnSolverDoes) {
  for (const JointKind kind : {JointKind::hinge, JointKind::slider}) {
    for (const bool exchanged : {false, true}) {
      BodySetup setup = sprung(kind, exchanged);
      const double free_m = largest_difference_m(setup, 2000);
      setup.joints[0].highest = 0.4 * setup.joints[0].rest;
      setup.joints[0].lowest = -setup.joints[0].highest;
      EXPECT_LT(largest_difference_m(setup, 2000), free_m + 0.1 * 4e-6) << static_cast<int>(kind) << exchanged;
    }
  }
}

TEST(MujocoWorld, ClosesLoopsWithinAMillionthOfARadius) {
  BodySetup setup = four_bar();
  setup.step_s = span_s / 2000;
  EngineBodySolver mujoco = engine_solver(setup);
  const JointSpecification& closing = setup.joints.back();
  for (int sample = 0; sample < 20; ++sample) {
    const Kinematics state = advance(mujoco, 100);
    const Eigen::Vector3d end_m =
        state.position_m.col(2) + rotation_matrix(state.orientation_wxyz.col(2)) * closing.anchor_A_m;
    EXPECT_LT((end_m - closing.anchor_B_m).norm(), 1e-6 * 4e-6) << sample;
  }
}

class DrivenJoints : public testing::TestWithParam<JointKind> {};

TEST_P(DrivenJoints, FollowTheirSignals) {
  constexpr double omega_per_s = 2e3;
  constexpr double h = 1e-6;
  const bool hinge = GetParam() == JointKind::hinge;
  const double amplitude = hinge ? 0.8 : 2e-6;
  for (const bool exchanged : {false, true}) {
    BodySetup setup = tumbling(GetParam(), exchanged);
    for (BodySpecification& body : setup.bodies) {
      body.angular_velocity_rad_per_s.setZero();
      body.velocity_m_per_s.setZero();
    }
    setup.step_s = h;
    ActuatorSpecification& motion = setup.actuators.emplace_back();
    motion.kind = ActuatorKind::joint_motion;
    motion.joint = 0;
    const auto drive = [&](AppliedLoads& applied) {
      const auto n = static_cast<double>(applied.hydrodynamic.step);
      const auto last = applied.actuation.cols() - 1;  // at the end of the step
      for (Eigen::Index node = 0; node <= last; ++node)
        applied.actuation(0, node) =
            amplitude * (1.0 - std::cos(omega_per_s * h * (n + static_cast<double>(node) / static_cast<double>(last))));
    };
    EngineBodySolver mujoco = engine_solver(setup);
    RigidBodySolver own(setup);
    const Kinematics theirs = advance(mujoco, 1000, drive, 1);
    const Kinematics ours = advance(own, 1000, drive, 1);
    const double moved_m = (ours.position_m.col(0) - setup.bodies[0].position_m).norm();
    EXPECT_GT(moved_m, 3e-7);
    EXPECT_LT((theirs.position_m - ours.position_m).norm(), 3.0 * omega_per_s * h * moved_m);
    EXPECT_LT((theirs.orientation_wxyz - ours.orientation_wxyz).norm(), 3.0 * omega_per_s * h);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, DrivenJoints, testing::Values(JointKind::hinge, JointKind::slider, JointKind::distance),
                         [](const auto& info) { return std::string(name_of(joint_names, info.param)); });

TEST(MujocoWorld, ContinuesJointsBitForBitAfterARestart) {
  const auto file = std::filesystem::temp_directory_path() / ("mujoco_restart_" + std::to_string(::getpid()));
  BodySetup setup = four_bar();
  setup.step_s = span_s / 1000;
  EngineBodySolver whole = engine_solver(setup);
  advance(whole, 300);
  whole.save(file);
  EngineBodySolver resumed = engine_solver(setup);
  resumed.restore(file);
  EXPECT_EQ(advance(whole, 300).position_m, advance(resumed, 300).position_m);
  EXPECT_EQ(whole.summarise().digest, resumed.summarise().digest);
  std::filesystem::remove(file);
}

TEST(MujocoWorld, RefusesWhatMujocoCannotRepresent) {
  BodySetup slider = four_bar();
  for (JointSpecification& joint : slider.joints) joint.kind = JointKind::slider;
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { engine_solver(slider); }), "closes a loop"));
}

}  // namespace
}  // namespace copepod::body
