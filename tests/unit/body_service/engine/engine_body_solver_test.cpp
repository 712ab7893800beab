#include "engine/engine_body_solver.hpp"

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <unistd.h>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "engine/engine_under_test.hpp"
#include "geometry/contact_time.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double step_s = 7.5e-10;

SpringSpecification spring_between(int A, int B, double rest_length_m) {
  SpringSpecification spring;
  spring.body_A = A;
  spring.body_B = B;
  spring.stiffness_N_per_m = 16.3;
  spring.damping_N_s_per_m = 1.6e-7;
  spring.rest_length_m = rest_length_m;
  return spring;
}

/// A swimmer off its rest lengths, tilted in space: its middle bead answers to two springs.
BodySetup swimmer(Integrator integrator) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 2) / 3.0;
  BodySetup setup = setup_of({bead("B2", -17e-6 * axis), bead("B1", Eigen::Vector3d::Zero()), bead("B3", 15e-6 * axis)},
                             step_s, integrator);
  setup.springs = {spring_between(0, 1, 16e-6), spring_between(1, 2, 16e-6)};
  return setup;
}

void drive(AppliedLoads& applied) {
  const double phase = 2.0 * std::numbers::pi * static_cast<double>(applied.hydrodynamic.step) / 4000.0;
  applied.hydrodynamic.force_N.row(0) << 1e-6 * std::sin(phase), -2e-6 * std::sin(phase), 1e-6 * std::sin(phase);
}

double largest_distance_m(const Kinematics& one, const Kinematics& other) {
  return (one.position_m - other.position_m).colwise().norm().maxCoeff();
}

// The two methods are the same one: what differs is rounding.
TEST(EngineBodySolver, MovesSpringsLikeOurOwnSemiImplicitEuler) {
  EngineBodySolver engine = engine_solver(swimmer(Integrator::runge_kutta_4));
  RigidBodySolver own(swimmer(Integrator::semi_implicit_euler));
  const Kinematics theirs = advance(engine, 4000, drive);
  const Kinematics ours = advance(own, 4000, drive);
  EXPECT_LT(largest_distance_m(theirs, ours), 1e-12 * 1e-6);
  EXPECT_GT((ours.position_m.col(0) - swimmer(Integrator::runge_kutta_4).bodies[0].position_m).norm(), 1e-7);
}

TEST(EngineBodySolver, DrivesAndBendsBodiesLikeOurOwnSemiImplicitEuler) {
  const auto driven = [](Integrator integrator) {
    BodySetup setup = swimmer(integrator);
    setup.bodies[1].position_m += Eigen::Vector3d(1e-6, 0, 0);
    setup.bodies[2].angular_velocity_rad_per_s = {0, 3e5, 0};
    setup.bends = {{0, 1, 2, 1e-11}};
    setup.actuators = {pair_force(0, 1),
                       pair_force(1, 2),
                       actuator_on(2, ActuatorKind::body_force, {1, 0, 0}),
                       actuator_on(2, ActuatorKind::world_force, {0, 1, 0}),
                       actuator_on(0, ActuatorKind::world_torque, {0, 0, 1}),
                       actuator_on(0, ActuatorKind::body_torque, {0, 1, 0})};
    setup.actuators[1].anchor_A_m = {0, 2e-6, 0};
    return setup;
  };
  const auto drive = [](AppliedLoads& applied) { applied.actuation.col(0) << 1e-6, 2e-6, 1e-6, -1e-6, 1e-12, 2e-12; };
  EngineBodySolver engine = engine_solver(driven(Integrator::runge_kutta_4));
  RigidBodySolver own(driven(Integrator::semi_implicit_euler));
  const Kinematics theirs = advance(engine, 1000, drive, 6);
  const Kinematics ours = advance(own, 1000, drive, 6);
  EXPECT_LT(largest_distance_m(theirs, ours), 1e-9 * 1e-6);
  EXPECT_GT((ours.position_m.col(2) - swimmer(Integrator::runge_kutta_4).bodies[2].position_m).norm(), 1e-8);
  EXPECT_GT((ours.orientation_wxyz.col(1) - Eigen::Vector4d(1, 0, 0, 0)).norm(), 1e-4) << "the anchor turns B1";
  EXPECT_LT((theirs.orientation_wxyz - ours.orientation_wxyz).norm(), 1e-9);
}

// The engines' integration error: half a step's way, h v/2, and halved with the step.
TEST(EngineBodySolver, IsHalfAStepsWayFromTheExactMotion) {
  const auto error_m = [](int refinement, double& fastest_m_per_s) {
    BodySetup coarse = swimmer(Integrator::runge_kutta_4);
    coarse.step_s /= refinement;
    EngineBodySolver engine = engine_solver(coarse);
    RigidBodySolver own(coarse);  // fourth order: exact here
    double largest_m = 0.0;
    fastest_m_per_s = 0.0;
    for (int sample = 0; sample < 20; ++sample) {
      const Kinematics theirs = advance(engine, 200 * refinement);
      const Kinematics ours = advance(own, 200 * refinement);
      largest_m = std::max(largest_m, largest_distance_m(theirs, ours));
      fastest_m_per_s = std::max(fastest_m_per_s, ours.velocity_m_per_s.colwise().norm().maxCoeff());
    }
    return largest_m;
  };
  double fastest_m_per_s = 0.0;
  const double whole_m = error_m(1, fastest_m_per_s);
  const double bound_m = 0.5 * step_s * fastest_m_per_s;
  EXPECT_LT(whole_m, 1.3 * bound_m);
  EXPECT_GT(whole_m, 0.3 * bound_m);
  EXPECT_NEAR(whole_m / error_m(2, fastest_m_per_s), 2.0, 0.1);
}

TEST(EngineBodySolver, KeepsFreeBodiesOnStraightLines) {
  BodySpecification ball = bead("ball", {1e-6, 2e-6, 3e-6});
  ball.velocity_m_per_s = {0.3, -0.2, 0.1};
  ball.angular_velocity_rad_per_s = {2e5, 0, 1e5};
  EngineBodySolver engine = engine_solver(setup_of({ball}, step_s));
  RigidBodySolver own(setup_of({ball}, step_s));
  const Kinematics theirs = advance(engine, 3000);
  const Kinematics ours = advance(own, 3000);
  EXPECT_LT(largest_distance_m(theirs, ours), 1e-17);
  EXPECT_TRUE(theirs.angular_velocity_rad_per_s.isApprox(ours.angular_velocity_rad_per_s, 1e-13));
  EXPECT_LT((theirs.orientation_wxyz - ours.orientation_wxyz).norm(), 1e-9);
}

TEST(EngineBodySolver, TumblesCapsulesToFirstOrder) {
  const auto error = [](double h) {
    BodySpecification body = capsule("capsule", {0, 0, 0});
    body.angular_velocity_rad_per_s = {3e5, 0, 5e5};
    EngineBodySolver engine = engine_solver(setup_of({body}, h));
    RigidBodySolver own(setup_of({body}, h));
    const auto steps = std::lround(4e-6 / h);
    return (advance(engine, steps).orientation_wxyz - advance(own, steps).orientation_wxyz).norm();
  };
  const double whole = error(4e-9);
  EXPECT_LT(whole, 5e-3);
  EXPECT_NEAR(whole / error(2e-9), 2.0, 0.2);
}

TEST(EngineBodySolver, PullsAtAnchorsLikeOurOwn) {
  BodySetup setup =
      setup_of({capsule("one", {0, 0, 0}), capsule("two", {0, 0, 30e-6})}, step_s, Integrator::semi_implicit_euler);
  setup.springs = {spring_between(0, 1, 20e-6)};
  setup.springs[0].anchor_A_m = {0, 1e-6, 4e-6};
  setup.springs[0].anchor_B_m = {1e-6, 0, -4e-6};
  EngineBodySolver engine = engine_solver(setup);
  RigidBodySolver own(setup);
  const Kinematics theirs = advance(engine, 500);
  const Kinematics ours = advance(own, 500);
  const double turned = (ours.orientation_wxyz.col(0) - Eigen::Vector4d(1, 0, 0, 0)).norm();
  EXPECT_GT(turned, 1e-3);
  EXPECT_LT((theirs.orientation_wxyz - ours.orientation_wxyz).norm(), 0.01 * turned);
  EXPECT_LT(largest_distance_m(theirs, ours), 1e-3 * 1e-6);
}

TEST(EngineBodySolver, KeepsABodyOnItsAxis) {
  const Eigen::Vector3d axis(0, 0.6, 0.8);
  BodySpecification rider = capsule("rider", {1e-6, 2e-6, 3e-6});
  rider.motion = MotionKind::axis;
  rider.axis = axis;
  const auto load = [](AppliedLoads& applied) {
    applied.hydrodynamic.force_N.col(0) << 1e-6, 2e-6, -1e-6;
    applied.hydrodynamic.torque_N_m.col(0) << 1e-12, 2e-12, 1e-12;
  };
  EngineBodySolver engine = engine_solver(setup_of({rider}, step_s));
  RigidBodySolver own(setup_of({rider}, step_s, Integrator::semi_implicit_euler));
  const Kinematics theirs = advance(engine, 2000, load);
  const Kinematics ours = advance(own, 2000, load);
  EXPECT_GT((ours.position_m.col(0) - rider.position_m).norm(), 1e-9);
  EXPECT_LT(largest_distance_m(theirs, ours), 1e-6 * (ours.position_m.col(0) - rider.position_m).norm());
  EXPECT_LT((theirs.angular_velocity_rad_per_s - ours.angular_velocity_rad_per_s).norm(),
            1e-3 * ours.angular_velocity_rad_per_s.norm());
}

/// A ball thrown at a row of others, one of them fixed: contacts, a spring and a joint at once.
BodySetup collision() {
  std::vector<BodySpecification> bodies{bead("thrown", {0, 0, 0})};
  bodies[0].velocity_m_per_s = {10, 0.1, 0};
  bodies.push_back(bead("hit", {9e-6, 1e-6, 0}));
  bodies.push_back(capsule("next", {18e-6, 0, 0}));
  bodies.push_back(bead("railed", {27e-6, 1e-6, 0}));
  bodies[3].motion = MotionKind::axis;
  bodies[3].axis = {1, 0, 0};
  bodies.push_back(bead("wall", {60e-6, 0, 0}));
  bodies[4].motion = MotionKind::fixed;
  BodySetup setup = setup_of(bodies, step_s);
  setup.springs = {spring_between(1, 4, 50e-6)};
  return setup;
}

TEST(EngineBodySolver, KeepsTouchingBodiesApartAndConservesTheirMomentum) {
  BodySetup setup = setup_of({bead("thrown", {0, 0, 0}), bead("hit", {9e-6, 1e-6, 0})}, step_s);
  setup.bodies[0].velocity_m_per_s = {10, 0, 0};
  EngineBodySolver engine = engine_solver(setup);
  double smallest_m = 1.0;
  Kinematics state;
  for (int sample = 0; sample < 100; ++sample) {
    state = advance(engine, 10);
    smallest_m = std::min(smallest_m, (state.position_m.col(1) - state.position_m.col(0)).norm());
  }
  EXPECT_GT(smallest_m, 8e-6 - 1e-8);  // the beads would be 3.5 µm past each other
  EXPECT_GT(state.velocity_m_per_s(0, 1), 4.0);
  EXPECT_LT((state.velocity_m_per_s.rowwise().sum() - Eigen::Vector3d(10, 0, 0)).norm(), 1e-11);
}

/// A bead that flies at a wall, or at another one.
BodySetup impact(double restitution, bool wall) {
  BodySetup setup = setup_of({bead("thrown", {0, 0, 5e-6})}, 1e-8);
  setup.bodies[0].velocity_m_per_s = {0, 0, -1};
  setup.contact = {stiffness_of_contact(4e-7, largest_inverse_mass_per_kg(setup.bodies)), restitution, 0.0};
  if (wall) setup.walls = {{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}, 0.0}};
  if (!wall) setup.bodies.push_back(bead("hit", {0, 0, -4e-6}));
  return setup;
}

TEST(EngineBodySolver, GivesContactsTheirRestitution) {
  for (const bool wall : {true, false}) {
    for (const double restitution : {0.1, 0.3, 0.6, 0.9, 1.0}) {
      EngineBodySolver engine = engine_solver(impact(restitution, wall));
      const Eigen::Matrix3Xd v = advance(engine, 500).velocity_m_per_s;
      EXPECT_NEAR(wall ? v(2, 0) : v(2, 0) - v(2, 1), restitution, 0.01) << (wall ? "wall" : "body");
    }
  }
}

TEST(EngineBodySolver, RefusesWallsThatMove) {
  BodySetup belt = impact(1.0, true);
  belt.walls[0].velocity_m_per_s = {1, 0, 0};
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { engine_solver(belt); }), "walls of engines are at rest"));
}

TEST(EngineBodySolver, ContinuesBitForBitAfterARestartInTheMiddleOfContacts) {
  const auto file = std::filesystem::temp_directory_path() / ("bullet_restart_" + std::to_string(::getpid()));
  EngineBodySolver whole = engine_solver(collision());
  EngineBodySolver first_part = engine_solver(collision());
  Kinematics expected;
  int contacts = 0;
  for (int stop = 0; stop < 8; ++stop) {
    const Kinematics before = advance(whole, 150);
    advance(first_part, 150);
    first_part.save(file);
    EngineBodySolver second_part = engine_solver(collision());
    second_part.restore(file);
    expected = advance(whole, 100);
    const Kinematics resumed = advance(second_part, 100);
    advance(first_part, 100);
    EXPECT_EQ(resumed.step, expected.step);
    EXPECT_EQ(resumed.position_m, expected.position_m) << stop;
    EXPECT_EQ(resumed.orientation_wxyz, expected.orientation_wxyz) << stop;
    EXPECT_EQ(second_part.summarise().digest, whole.summarise().digest) << stop;
    if ((expected.velocity_m_per_s - before.velocity_m_per_s).norm() > 1.0) ++contacts;
  }
  std::filesystem::remove(file);
  EXPECT_GE(contacts, 2);
}

TEST(EngineBodySolver, RefusesStatesOfTheOtherSolver) {
  const auto file = std::filesystem::temp_directory_path() / ("foreign_state_" + std::to_string(::getpid()));
  RigidBodySolver own(collision());
  own.save(file);
  EngineBodySolver engine = engine_solver(collision());
  EXPECT_TRUE(contains(reason_of<StorageError>([&] { engine.restore(file); }), "another case"));
  std::filesystem::remove(file);
}

TEST(EngineBodySolver, RefusesWhatCannotBeComputed) {
  EXPECT_TRUE(
      contains(reason_of<CaseError>([] { const EngineBodySolver none = engine_solver(setup_of({}, 0.0)); }), "step_s"));
  EngineBodySolver engine = engine_solver(swimmer(Integrator::runge_kutta_4));
  Kinematics next;
  AppliedLoads applied = no_loads(engine, 3);
  applied.hydrodynamic.force_N(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { engine.step(applied, next); }), "not finite"));
  applied = no_loads(engine, 3);
  applied.hydrodynamic.step = 5;
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { engine.step(applied, next); }), "loads of step 5"));
}

TEST(EngineBodySolver, TurnsOtherShapesLikeOurOwnSolver) {
  for (const Shape& shape :
       {ellipsoid({3e-6, 4e-6, 6e-6}), box({4e-6, 6e-6, 9e-6}), cylinder(4e-6, 3e-6), dumbbell()}) {
    BodySetup setup = setup_of({shaped("top", {0, 0, 0}, shape)}, 1e-7);
    setup.bodies[0].orientation_wxyz = Eigen::Vector4d(0.8, 0.3, -0.4, 0.2).normalized();
    setup.bodies[0].angular_velocity_rad_per_s = {2e4, -1e4, 3e4};
    EngineBodySolver engine = engine_solver(setup);
    RigidBodySolver own(setup);
    const Kinematics theirs = advance(engine, 1000);
    const Kinematics ours = advance(own, 1000);
    EXPECT_LT((theirs.orientation_wxyz - ours.orientation_wxyz).norm(), 4e-4 * 4e4 * 1e-4)
        << name_of(shape_names, shape.kind);
    EXPECT_GT((theirs.orientation_wxyz.col(0) - setup.bodies[0].orientation_wxyz).norm(), 1.0);
    EXPECT_LT((theirs.angular_velocity_rad_per_s - ours.angular_velocity_rad_per_s).norm(), 0.01 * 4e4);
    EXPECT_LT(theirs.position_m.norm(), 1e-15);
  }
}

TEST(EngineBodySolver, LetsOtherShapesRestOnTheirSides) {
  for (const auto& [shape, height_m] :
       {std::pair(box({8e-6, 6e-6, 4e-6}), 2e-6), std::pair(cylinder(4e-6, 5e-6), 2.5e-6),
        std::pair(ellipsoid({6e-6, 5e-6, 3e-6}), 3e-6), std::pair(dumbbell(), 3e-6)}) {
    const BodySetup setup = falling(shaped("dropped", {0, 0, 1.1 * height_m}, shape));
    EngineBodySolver engine = engine_solver(setup);
    const Kinematics rest = advance(engine, 3000);
    EXPECT_NEAR(rest.position_m(2, 0), height_m, 2e-3 * height_m) << name_of(shape_names, shape.kind);
    EXPECT_LT((rest.orientation_wxyz.col(0) - setup.bodies[0].orientation_wxyz).norm(), 1e-3);
    EXPECT_LT(rest.velocity_m_per_s.norm(), 1e-4);
  }
}

TEST(EngineBodySolver, FallsByItsBuoyantWeight) {
  BodySetup setup = setup_of({bead("ball", {0, 0, 0})}, 1e-6);
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.fluid_density_kg_per_m3 = 1000;
  const double mass_kg = 5.44e-13;
  const double volume_m3 = 4.0 / 3.0 * std::numbers::pi * std::pow(4e-6, 3);
  EngineBodySolver engine = engine_solver(setup);
  EXPECT_NEAR(advance(engine, 100).velocity_m_per_s(2, 0), -9.81 * (1 - 1000 * volume_m3 / mass_kg) * 100e-6, 1e-15);
}

}  // namespace
}  // namespace copepod::body
