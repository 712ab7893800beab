#include "driving/prescribed_bodies.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>

#include <gtest/gtest.h>

#include "fakes.hpp"

namespace copepod::coupler {
namespace {

/// A free sphere between two that swing and turn.
std::vector<BodySpecification> bodies() {
  std::vector<BodySpecification> result(3);
  for (std::size_t i = 0; i < 3; ++i) {
    result[i].name = std::string(1, static_cast<char>('a' + i));
    result[i].shape = {ShapeKind::sphere, 0.5, 0.0};
    result[i].mass_kg = 1.0;
    result[i].position_m = {10.0 * static_cast<double>(i), 0, 0};
  }
  result[0].velocity_m_per_s = {0, 3, 0};
  result[1].velocity_m_per_s = {0, 0, 2};
  result[2].angular_velocity_rad_per_s = {0, 0, 5};
  return result;
}

Signal sinusoid(std::int64_t period_steps) {
  Signal signal;
  signal.kind = SignalKind::sinusoid;
  signal.amplitude = 1.0;
  signal.period_steps = period_steps;
  return signal;
}

BodySetup setup_of(const std::vector<BodySpecification>& bodies, double step_s) {
  BodySetup setup;
  setup.step_s = step_s;
  setup.bodies = bodies;
  return setup;
}

/// Motion of the three bodies, of which the first and the last are prescribed.
class Motion {
 public:
  explicit Motion(std::int64_t period_steps, const std::vector<BodySpecification>& all = bodies(),
                  double step_s = 0.01) {
    const std::vector<PrescribedBody> prescribed{{0, sinusoid(period_steps)}, {2, sinusoid(period_steps)}};
    driving = DrivingProtocol({}, prescribed);
    BodySetup setup = setup_of(all, step_s);
    take_out(prescribed, setup);
    solver_ =
        std::make_unique<PrescribedBodies>(std::make_unique<PointMassBodies>(setup), all, prescribed, driving, setup);
    applied_.hydrodynamic.resize(3);
    applied_.hydrodynamic.force_N.setConstant(0.25);
    applied_.hydrodynamic.torque_N_m.setZero();
    applied_.actuation.resize(0, 3);
    solver_->kinematics(state);
  }
  void advance(std::int64_t steps) {
    for (std::int64_t i = 0; i < steps; ++i) {
      applied_.hydrodynamic.step = state.step;
      solver_->step(applied_, state);
    }
  }
  [[nodiscard]] BodySolver& solver() { return *solver_; }
  Kinematics state;
  DrivingProtocol driving{{}};

 private:
  std::unique_ptr<BodySolver> solver_;
  AppliedLoads applied_;
};

TEST(PrescribedBodies, FollowTheIntegralOfTheirVelocity) {
  Motion run(80);
  for (const std::int64_t steps : {13L, 27L, 40L}) {
    run.advance(steps);
    const double omega = 2.0 * std::numbers::pi / 0.8;
    const double time_s = 0.01 * static_cast<double>(run.state.step);
    const double swing = (1.0 - std::cos(omega * time_s)) / omega;  // ∫ sin ωt dt
    EXPECT_NEAR(run.state.position_m(1, 0), 3.0 * swing, 1e-12);
    EXPECT_NEAR(run.state.velocity_m_per_s(1, 0), 3.0 * std::sin(omega * time_s), 1e-12);
    EXPECT_NEAR(run.state.orientation_wxyz(3, 2), std::sin(2.5 * swing), 1e-12);
    EXPECT_NEAR(run.state.angular_velocity_rad_per_s(2, 2), 5.0 * std::sin(omega * time_s), 1e-12);
    EXPECT_NEAR(run.state.position_m(0, 1), 10.0 + 0.125 * time_s * time_s, 1e-12) << "the free body";
  }
}

TEST(PrescribedBodies, DoNotDriftInManyPeriods) {
  Motion run(20);
  run.advance(20 * 5000);
  EXPECT_NEAR(run.state.position_m(1, 0), 0.0, 1e-12);
  EXPECT_NEAR(run.state.orientation_wxyz(3, 2), 0.0, 1e-12);
}

TEST(PrescribedBodies, ResumeBitForBit) {
  const auto file = std::filesystem::temp_directory_path() / "copepod_prescribed_bodies";
  Motion whole(37);
  whole.advance(50);
  whole.solver().save(file.string());
  whole.advance(61);
  Motion resumed(37);
  resumed.solver().restore(file.string());
  resumed.solver().kinematics(resumed.state);
  resumed.advance(61);
  std::filesystem::remove(file);
  EXPECT_EQ(resumed.state.step, whole.state.step);
  EXPECT_EQ(resumed.state.position_m, whole.state.position_m);
  EXPECT_EQ(resumed.state.orientation_wxyz, whole.state.orientation_wxyz);
  EXPECT_EQ(resumed.state.velocity_m_per_s, whole.state.velocity_m_per_s);
}

/// One steered at once, the other within 20 steps; a run that continues from its course and way has the same bits.
TEST(PrescribedBodies, MoveAsTheyAreSteered) {
  Motion run(80), resumed(80);
  run.advance(40);
  const double before_m = run.state.position_m(1, 0);
  run.driving.steer(0, 40, 0.5, 0);
  run.driving.steer(1, 40, -2.0, 20);
  run.advance(30);
  EXPECT_NEAR(run.state.position_m(1, 0), before_m + 0.5 * 3.0 * 0.3, 1e-12);
  EXPECT_EQ(run.state.velocity_m_per_s(1, 0), 1.5);
  EXPECT_NEAR(run.state.angular_velocity_rad_per_s(2, 2), -10.0, 1e-12);
  const auto file = std::filesystem::temp_directory_path() / "copepod_steered_bodies";
  run.solver().save(file.string());
  resumed.solver().restore(file.string());
  for (const std::size_t i : {0, 1}) {
    resumed.driving.follow(i, run.driving.steered()[i]);
    resumed.driving.resume_way(i, run.driving.ways()[i]);
  }
  resumed.solver().kinematics(resumed.state);
  for (Motion* each : {&run, &resumed}) each->advance(50);
  std::filesystem::remove(file);
  EXPECT_EQ(resumed.state.position_m, run.state.position_m);
  EXPECT_EQ(resumed.state.orientation_wxyz, run.state.orientation_wxyz);
}

TEST(PrescribedBodies, EndTheRunWhereTheyMeetAnother) {
  std::vector<BodySpecification> close = bodies();
  close[1].position_m = {0, 1.1, 0};
  close[1].velocity_m_per_s.setZero();
  Motion run(1000, close);
  try {
    run.advance(500);
    FAIL() << "bodies pass through each other";
  } catch (const SolverError& error) {
    EXPECT_NE(std::string(error.what()).find("body 'a' met body 'b'"), std::string::npos) << error.what();
  }
}

TEST(TakeOut, KeepsWhatTheOtherBodiesAreTiedTo) {
  BodySetup setup = setup_of(bodies(), 0.01);
  setup.bodies.push_back(setup.bodies[1]);
  setup.springs.resize(1);
  setup.springs[0].body_A = 3;
  setup.springs[0].body_B = 1;
  setup.joints.resize(1);
  setup.joints[0].body_A = 3;
  setup.actuators = {{ActuatorKind::world_force, 3}};
  take_out({{0, {}}, {2, {}}}, setup);
  ASSERT_EQ(setup.bodies.size(), 2U);
  EXPECT_EQ(setup.bodies[0].name, "b");
  EXPECT_EQ(setup.springs[0].body_A, 1);
  EXPECT_EQ(setup.springs[0].body_B, 0);
  EXPECT_EQ(setup.joints[0].body_A, 1);
  EXPECT_EQ(setup.joints[0].body_B, -1);
  EXPECT_EQ(setup.actuators[0].body_A, 1);
  EXPECT_EQ(setup.actuators[0].body_B, -1);
}

}  // namespace
}  // namespace copepod::coupler
