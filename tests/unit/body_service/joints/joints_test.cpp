#include "joints/joints.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "joints/joint_rows.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double joint_cell_m = 1e-6;

/// Largest |C| of all joints between bodies: metres, and cosines of directions.
double largest_error(const BodySetup& setup, const Kinematics& now) {
  double largest = 0.0;
  for (const JointSpecification& joint : setup.joints) {
    const auto start = [&](int body) -> JointSide {
      return {setup.bodies[body].position_m, rotation_matrix(setup.bodies[body].orientation_wxyz)};
    };
    const auto end = [&](int body) -> JointSide {
      return {now.position_m.col(body), rotation_matrix(now.orientation_wxyz.col(body))};
    };
    const JointEquations equations(joint, false, start(joint.body_A), start(joint.body_B));
    std::array<JointRow, 6> rows;
    equations.evaluate(end(joint.body_A), end(joint.body_B), {}, rows.data());
    for (int row = 0; row < equations.rows(); ++row) largest = std::max(largest, std::abs(rows[row].error));
  }
  return largest;
}

/// Three beads and a capsule with a joint of each kind, tumbling; body i is at place `order[i]`.
BodySetup tumbling(const std::vector<int>& order) {
  BodySetup setup = setup_of({}, 2e-6);
  setup.bodies.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    BodySpecification body = capsule("body " + std::to_string(i), {7e-6 * static_cast<double>(i), 0, 0});
    body.orientation_wxyz = Eigen::Vector4d(1, 0.2 * static_cast<double>(i), 0.1, 0).normalized();
    body.angular_velocity_rad_per_s = {100.0, 50.0 * static_cast<double>(i), 200};
    setup.bodies[order[i]] = body;
  }
  const auto join = [&](JointKind kind, int A, int B, const Eigen::Vector3d& place_m) {
    const auto in_frame = [&](int i) -> Eigen::Vector3d {
      const BodySpecification& body = setup.bodies[order[i]];
      return rotation_matrix(body.orientation_wxyz).transpose() * (place_m - body.position_m);
    };
    setup.joints.push_back({kind, order[A], order[B], in_frame(A), in_frame(B), Eigen::Vector3d(0, 0.6, 0.8)});
  };
  join(JointKind::ball, 0, 1, {3e-6, 1e-6, 0});
  join(JointKind::hinge, 2, 1, {1e-5, 1e-6, 0});
  join(JointKind::slider, 2, 3, {2e-5, 0, 1e-6});
  join(JointKind::fixed, 4, 3, {2.5e-5, 0, 1e-6});
  setup.joints.push_back({JointKind::distance, order[5], order[4], {0, 0, 4e-6}, {0, 0, -4e-6}, {0, 0, 1}});
  return setup;
}

std::vector<int> identity() {
  std::vector<int> order(6);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

Eigen::Vector3d momentum_of(const Kinematics& state) { return state.velocity_m_per_s.rowwise().sum(); }

/// Angular momentum about the origin over the mass of a body, of capsules of the same shape.
Eigen::Vector3d angular_momentum_of(const Kinematics& state) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const Eigen::Matrix3d inertia = inertia_tensor_kg_m2(capsule("", {0, 0, 0}).shape, 1.0);
  for (Eigen::Index body = 0; body < state.bodies(); ++body) {
    const Eigen::Matrix3d R = rotation_matrix(state.orientation_wxyz.col(body));
    const Eigen::Vector3d p = state.position_m.col(body);
    sum += p.cross(Eigen::Vector3d(state.velocity_m_per_s.col(body))) +
           R * inertia * R.transpose() * state.angular_velocity_rad_per_s.col(body);
  }
  return sum;
}

TEST(Joints, ExertNeitherForceNorTorqueOnTheWhole) {
  RigidBodySolver solver(tumbling(identity()));
  const Kinematics start = advance(solver, 1);
  const Kinematics end = advance(solver, 2000);
  EXPECT_LT((momentum_of(end) - momentum_of(start)).norm(), 1e-12 * start.velocity_m_per_s.norm());
  // The integrator of fourth order keeps it to its error only.
  EXPECT_LT((angular_momentum_of(end) - angular_momentum_of(start)).norm(), 1e-7 * angular_momentum_of(start).norm());
}

/// A pair of tumbling capsules that overlap, with a joint in the middle between their centres.
BodySetup pair_of(JointKind kind) {
  BodySetup setup = setup_of({capsule("a", {-5e-6, 0, 0}), capsule("b", {5e-6, 0, 0})}, 2e-6);
  setup.bodies[0].angular_velocity_rad_per_s = {1000, 500, 2000};
  setup.bodies[1].angular_velocity_rad_per_s = {-700, 900, 100};
  const Eigen::Vector3d anchor_m(kind == JointKind::distance ? 1e-6 : 5e-6, 0, 0);
  setup.joints = {{kind, 0, 1, anchor_m, -anchor_m, Eigen::Vector3d(0, 0.6, 0.8)}};
  return setup;
}

TEST(Joints, StayClosed) {
  // Rounding of a coordinate of 10 cells is 1e-15 of a cell; the correction leaves a few of that, whatever the step.
  const char* longer = std::getenv("COPEPOD_JOINT_STEPS");
  const std::int64_t steps = longer == nullptr ? 10000 : std::atoll(longer);
  for (const JointKind kind : {JointKind::ball, JointKind::hinge, JointKind::fixed, JointKind::distance}) {
    const BodySetup setup = pair_of(kind);
    RigidBodySolver solver(setup);
    const Kinematics end = advance(solver, steps);
    BodySetup lengths = setup;
    if (kind != JointKind::distance) lengths.joints[0].kind = JointKind::ball;
    EXPECT_LT(largest_error(lengths, end), 1e-10 * joint_cell_m) << static_cast<int>(kind);
    EXPECT_LT(largest_error(setup, end), 1e-12) << static_cast<int>(kind);
    if (longer != nullptr) std::printf("joint kind %d: %.2e m\n", static_cast<int>(kind), largest_error(lengths, end));
  }
}

TEST(Joints, HaveTheSameBitsInWhateverOrderTheBodiesAre) {
  const std::vector<int> shuffled{4, 1, 5, 0, 3, 2};
  RigidBodySolver one(tumbling(identity()));
  RigidBodySolver other(tumbling(shuffled));
  const Kinematics a = advance(one, 300);
  const Kinematics b = advance(other, 300);
  for (int body = 0; body < 6; ++body) {
    EXPECT_EQ(a.position_m.col(body), b.position_m.col(shuffled[body])) << body;
    EXPECT_EQ(a.orientation_wxyz.col(body), b.orientation_wxyz.col(shuffled[body])) << body;
    EXPECT_EQ(a.angular_velocity_rad_per_s.col(body), b.angular_velocity_rad_per_s.col(shuffled[body])) << body;
  }
}

TEST(Joints, FixedMakeOneBodyOfTwo) {
  // Two beads turn about their common centre like a dumbbell, about an axis of inertia: uniformly.
  constexpr double speed = 1e3;
  BodySetup setup = setup_of({bead("a", {-6e-6, 0, 0}), bead("b", {6e-6, 0, 0})}, 1e-3 / speed);
  for (auto& body : setup.bodies) {
    body.angular_velocity_rad_per_s = {0, 0, speed};
    body.velocity_m_per_s = {0, speed * body.position_m.x(), 0};
  }
  setup.joints = {{JointKind::fixed, 0, 1, {6e-6, 0, 0}, {-6e-6, 0, 0}, {0, 0, 1}}};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, 1000);
  EXPECT_LT((end.position_m.col(1) - Eigen::Vector3d(6e-6 * std::cos(1.0), 6e-6 * std::sin(1.0), 0)).norm(), 1e-16);
  EXPECT_NEAR(end.orientation_wxyz(3, 0), std::sin(0.5), 1e-11);
}

TEST(Joints, SlidersLeaveTheMotionAlongTheirAxis) {
  BodySetup setup = setup_of({bead("a", {0, 0, 0})}, 1e-5);
  const Eigen::Vector3d axis(0.6, 0, 0.8);
  setup.joints = {{JointKind::slider, 0, -1, {1e-6, 0, 0}, {1e-6, 0, 0}, axis}};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, 100, [](AppliedLoads& applied) {
    applied.hydrodynamic.force_N.col(0) << 1e-12, 2e-12, 0;
    applied.hydrodynamic.torque_N_m.col(0) << 1e-17, 0, 1e-17;
  });
  const double along_m = 0.5 * (0.6e-12 / 5.44e-13) * 1e-6;
  EXPECT_LT((end.position_m.col(0) - along_m * axis).norm(), 1e-12 * along_m);
  EXPECT_LT((end.orientation_wxyz.col(0) - Eigen::Vector4d(1, 0, 0, 0)).norm(), 1e-14);
}

TEST(Joints, OfBodiesOfAnAxisLeaveTheAxis) {
  BodySetup setup = setup_of({bead("a", {0, 0, 0}), bead("b", {2e-5, 0, 0})}, 1e-5);
  setup.bodies[0].motion = MotionKind::axis;
  setup.joints = {{JointKind::fixed, 0, 1, {0, 0, 0}, {-2e-5, 0, 0}, {0, 0, 1}}};
  RigidBodySolver solver(setup);
  const Kinematics end =
      advance(solver, 10, [](AppliedLoads& applied) { applied.hydrodynamic.force_N.col(1) << 1e-12, 0, 1e-12; });
  const double along_m = 0.5 * (1e-12 / (2 * 5.44e-13)) * 1e-8;
  EXPECT_NEAR(end.position_m(2, 0), along_m, 1e-12 * along_m);
  EXPECT_NEAR(end.position_m(2, 1), along_m, 1e-12 * along_m);
  EXPECT_EQ(end.position_m(0, 0), 0.0);
}

TEST(Joints, ResumeWithTheSameBits) {
  const std::string path = testing::TempDir() + "jointed.state";
  RigidBodySolver whole(tumbling(identity()));
  advance(whole, 100);
  whole.save(path);
  advance(whole, 100);
  RigidBodySolver resumed(tumbling(identity()));
  resumed.restore(path);
  advance(resumed, 100);
  EXPECT_EQ(resumed.summarise().digest, whole.summarise().digest);
}

std::string refusal_of(const std::function<void(BodySetup&)>& change) {
  BodySetup setup = setup_of({bead("a", {0, 0, 0}), bead("b", {2e-5, 0, 0})}, 1e-5);
  setup.joints = {{JointKind::hinge, 0, 1, {1e-5, 0, 0}, {-1e-5, 0, 0}, {0, 0, 1}}};
  change(setup);
  return reason_of<CaseError>([&] { const RigidBodySolver solver(setup); });
}

TEST(Joints, RefuseSetupsThatAreNotValid) {
  EXPECT_TRUE(contains(refusal_of([](auto& it) { it.joints[0].body_B = 2; }), "Correct the indices"));
  EXPECT_TRUE(contains(refusal_of([](auto& it) { it.joints[0].body_B = 0; }), "'a' to itself"));
  EXPECT_TRUE(contains(refusal_of([](auto& it) { it.joints[0].axis *= 2; }), "axis has length 2"));
  EXPECT_TRUE(contains(refusal_of([](auto& it) { it.joints[0].anchor_A_m[1] = NAN; }), "not finite"));
  EXPECT_TRUE(
      contains(refusal_of([](auto& it) { it.bodies[1].motion = MotionKind::prescribed; }), "motion: prescribed"));
  EXPECT_TRUE(contains(refusal_of([](auto& it) {
                         for (auto& body : it.bodies) body.motion = MotionKind::fixed;
                       }),
                       "nothing that it joins can move"));
  EXPECT_TRUE(contains(refusal_of([](auto& it) {
                         it.joints[0].kind = JointKind::distance;
                         it.joints[0].anchor_A_m = {1e-5, 0, 0};
                       }),
                       "has no length"));
  EXPECT_TRUE(contains(refusal_of([](auto& it) { it.joints[0].anchor_A_m[0] = 5e-6; }), "do not meet"));
}

}  // namespace
}  // namespace copepod::body
