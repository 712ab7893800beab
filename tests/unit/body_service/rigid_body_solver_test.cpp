#include "rigid_body_solver.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <unistd.h>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"

namespace copepod::body {
namespace {

/// Swimmers side by side, each three tilted capsules with anchored springs; body i is at place `order[i]`.
BodySetup swarm(int swimmers, const std::vector<int>& order) {
  std::vector<BodySpecification> bodies(order.size());
  BodySetup setup = setup_of({}, 1e-9);
  for (int swimmer = 0; swimmer < swimmers; ++swimmer) {
    for (int part = 0; part < 3; ++part) {
      const int index = 3 * swimmer + part;
      BodySpecification body = capsule("body " + std::to_string(index), {4e-5 * swimmer, 0, 3e-5 * part});
      body.orientation_wxyz = Eigen::Vector4d(1, 0.1 * swimmer, 0.05 * part, 0).normalized();
      body.angular_velocity_rad_per_s = {1e3, 0, 2e3 * part};
      bodies[order[index]] = body;
      if (part == 0) continue;
      SpringSpecification spring;
      spring.body_A = order[index - 1];
      spring.body_B = order[index];
      spring.stiffness_N_per_m = 1.7;
      spring.damping_N_s_per_m = 1e-7;
      spring.rest_length_m = 1.8e-5;
      spring.anchor_A_m = {0, 1e-6, 4e-6};
      spring.anchor_B_m = {1e-6, 0, -4e-6};
      setup.springs.push_back(spring);
      setup.actuators.push_back(pair_force(order[index - 1], order[index]));
      setup.actuators.push_back(actuator_on(order[index], ActuatorKind::body_force, {0, 0.6, 0.8}));
    }
  }
  setup.bodies = bodies;
  return setup;
}

std::vector<int> identity(int bodies) {
  std::vector<int> order(bodies);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// Loads that depend on the body and on the step.
void shake(AppliedLoads& applied, const std::vector<int>& order) {
  const double phase = 1e-2 * static_cast<double>(applied.hydrodynamic.step);
  for (std::size_t body = 0; body < order.size(); ++body) {
    const double strength = 1e-6 * static_cast<double>(body + 1);
    applied.hydrodynamic.force_N.col(order[body]) << strength * std::sin(phase), 0, strength;
    applied.hydrodynamic.torque_N_m.col(order[body]) << 0, 1e-6 * strength * std::cos(phase), 0;
  }
  for (Eigen::Index actuator = 0; actuator < applied.actuation.rows(); ++actuator) {
    for (Eigen::Index node = 0; node < applied.actuation.cols(); ++node) {
      const double later = phase + 0.5e-2 * static_cast<double>(node);
      applied.actuation(actuator, node) = 1e-6 * static_cast<double>(actuator + 1) * std::sin(later);
    }
  }
}

TEST(RigidBodySolver, RefusesContactsOfOtherShapesByName) {
  BodySetup setup =
      setup_of({bead("ball", {0, 0, 0}), shaped("egg", {20e-6, 0, 0}, ellipsoid({4e-6, 4e-6, 8e-6}))}, 1e-9);
  EXPECT_NO_THROW(RigidBodySolver{setup});
  setup.contact.stiffness_N_per_m = 1.0;
  const std::string reason = reason_of<CaseError>([&] { RigidBodySolver{setup}; });
  EXPECT_TRUE(contains(reason, "body 'egg' has shape ellipsoid"));
  EXPECT_TRUE(contains(reason, "solver: bullet"));
}

TEST(RigidBodySolver, GivesTheSameBitsInWhateverOrderTheBodiesAre) {
  constexpr int swimmers = 10;
  std::vector<int> scattered = identity(3 * swimmers);
  std::reverse(scattered.begin(), scattered.end());
  std::rotate(scattered.begin(), scattered.begin() + 7, scattered.end());
  std::swap(scattered[0], scattered[15]);
  RigidBodySolver plain(swarm(swimmers, identity(3 * swimmers)));
  RigidBodySolver mixed(swarm(swimmers, scattered));
  const auto first = advance(
      plain, 200, [&](auto& loads) { shake(loads, identity(3 * swimmers)); }, 4 * swimmers);
  const auto second = advance(
      mixed, 200, [&](auto& loads) { shake(loads, scattered); }, 4 * swimmers);
  for (int body = 0; body < 3 * swimmers; ++body) {
    EXPECT_EQ(first.position_m.col(body), second.position_m.col(scattered[body])) << body;
    EXPECT_EQ(first.orientation_wxyz.col(body), second.orientation_wxyz.col(scattered[body])) << body;
    EXPECT_EQ(first.angular_velocity_rad_per_s.col(body), second.angular_velocity_rad_per_s.col(scattered[body]));
  }
}

TEST(RigidBodySolver, MovesTheSameWaySeenFromAMovingTrain) {
  const Eigen::Vector3d train_m_per_s(0.3, -0.2, 0.5);
  BodySetup setup = swarm(2, identity(6));
  RigidBodySolver standing(setup);
  for (auto& body : setup.bodies) body.velocity_m_per_s += train_m_per_s;
  RigidBodySolver moving(setup);
  const auto first = advance(
      standing, 2000, [](auto& loads) { shake(loads, identity(6)); }, 8);
  const auto second = advance(
      moving, 2000, [](auto& loads) { shake(loads, identity(6)); }, 8);
  const Eigen::Matrix3Xd seen = second.position_m.colwise() - train_m_per_s * 2000 * setup.step_s;
  EXPECT_LT((seen - first.position_m).norm() / first.position_m.norm(), 1e-12);
  EXPECT_LT((second.orientation_wxyz - first.orientation_wxyz).norm(), 1e-9);
}

TEST(RigidBodySolver, ContinuesBitForBitAfterARestart) {
  const auto file = std::filesystem::temp_directory_path() / ("restart_" + std::to_string(::getpid()));
  const auto load = [](AppliedLoads& applied) { shake(applied, identity(6)); };
  const BodySetup setup = swarm(2, identity(6));
  RigidBodySolver whole(setup);
  const Kinematics expected = advance(whole, 300, load, 8);

  RigidBodySolver first_part(setup);
  advance(first_part, 123, load, 8);
  first_part.save(file);
  RigidBodySolver second_part(setup);
  second_part.restore(file);
  std::filesystem::remove(file);
  Kinematics resumed;
  second_part.kinematics(resumed);
  EXPECT_EQ(resumed.step, 123);
  EXPECT_EQ(second_part.summarise().digest, first_part.summarise().digest);
  resumed = advance(second_part, 177, load, 8);
  EXPECT_EQ(resumed.step, 300);
  EXPECT_EQ(resumed.position_m, expected.position_m);
  EXPECT_EQ(resumed.orientation_wxyz, expected.orientation_wxyz);
  EXPECT_EQ(second_part.summarise().digest, whole.summarise().digest);
  EXPECT_NE(second_part.summarise().digest, first_part.summarise().digest);
}

TEST(RigidBodySolver, NamesTheBodyWhoseMotionIsNotFinite) {
  for (const double spoiled : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RigidBodySolver solver(swarm(2, identity(6)));
    Kinematics next;
    AppliedLoads applied = no_loads(solver, 6, 8);
    applied.hydrodynamic.torque_N_m(1, 3) = spoiled;
    const std::string reason = reason_of<SolverError>([&] { solver.step(applied, next); });
    EXPECT_TRUE(contains(reason, "motion of body 'body 3' is not finite") ||
                contains(reason, "motion of body 'body 4' is not finite"));
  }
}

TEST(RigidBodySolver, EndsWhenDrivenBodiesMeet) {
  BodySetup setup = setup_of({bead("left", {0, 0, 0}), bead("right", {0, 0, 9e-6})}, 1e-9);
  setup.actuators = {pair_force(0, 1)};
  RigidBodySolver solver(setup);
  const std::string reason = reason_of<SolverError>([&] {
    advance(
        solver, 100000, [](AppliedLoads& applied) { applied.actuation.setConstant(-1e-6); }, 1);
  });
  EXPECT_TRUE(contains(reason, "bodies 'left' and 'right' overlap"));
}

TEST(RigidBodySolver, RefusesBodiesThatOverlapAtTheStart) {
  const BodySetup setup = setup_of({bead("one", {0, 0, 0}), bead("two", {0, 0, 7e-6})}, 1e-9);
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { const RigidBodySolver solver(setup); }), "'one' and 'two'"));
}

TEST(RigidBodySolver, RefusesAStepThatIsNoTime) {
  for (const double step_s : {0.0, -1.0, std::nan("")}) {
    EXPECT_TRUE(contains(reason_of<CaseError>([&] { const RigidBodySolver solver(setup_of({}, step_s)); }), "step_s"));
  }
}

TEST(RigidBodySolver, RefusesLoadsOfAnotherStepOrShape) {
  Kinematics next;
  {
    RigidBodySolver solver(swarm(1, identity(3)));
    AppliedLoads applied = no_loads(solver, 3, 4);
    applied.hydrodynamic.step = 5;
    EXPECT_TRUE(contains(reason_of<SolverError>([&] { solver.step(applied, next); }), "loads of step 5"));
  }
  {
    RigidBodySolver solver(swarm(1, identity(3)));
    AppliedLoads applied = no_loads(solver, 3, 4);
    applied.actuation.resize(4, 1);
    EXPECT_TRUE(contains(reason_of<SolverError>([&] { solver.step(applied, next); }), "wrong shape"));
  }
}

TEST(RigidBodySolver, RunsWithoutBodies) {
  RigidBodySolver solver(setup_of({}, 1e-9));
  EXPECT_EQ(advance(solver, 3).step, 3);
}

TEST(RigidBodySolver, AnnouncesEveryShapeMotionAndIntegratorItHas) {
  const auto features = rigid_body_capabilities().features;
  for (const char* feature :
       {"shape:sphere", "shape:capsule", "motion:free", "motion:fixed", "motion:prescribed", "motion:axis",
        "integrator:runge_kutta_4", "integrator:semi_implicit_euler", "contact", "walls", "periodic", "checkpoint"}) {
    EXPECT_TRUE(features.contains(feature)) << feature;
  }
}

TEST(RigidBodySolver, TellsTheNodesOfItsIntegrator) {
  BodySetup setup = setup_of({}, 1e-9, Integrator::semi_implicit_euler);
  EXPECT_EQ(RigidBodySolver(setup).driving_nodes(), std::vector<double>{0.0});
  setup.integrator = Integrator::runge_kutta_4;
  EXPECT_EQ(RigidBodySolver(setup).driving_nodes(), (std::vector<double>{0.0, 0.5, 1.0}));
}

}  // namespace
}  // namespace copepod::body
