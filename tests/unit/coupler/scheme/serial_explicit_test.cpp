#include "scheme/serial_explicit.hpp"

#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "fakes.hpp"

namespace copepod::coupler {
namespace {

/// Keeps what it saw.
class Witness final : public Observer {
 public:
  void observe(const StepRecord& record) override {
    steps.push_back(record.step);
    raw.push_back(record.raw.force_N(2, 0));
    applied.push_back(record.applied.force_N(2, 0));
    velocity.push_back(record.kinematics.velocity_m_per_s(2, 0));
  }
  void finish(const StepRecord& last) override { finished_at = last.step; }
  std::vector<std::int64_t> steps;
  std::vector<double> raw;
  std::vector<double> applied;
  std::vector<double> velocity;
  std::int64_t finished_at = -1;
};

bool never(std::int64_t) { return false; }

BodySetup one_ball() {
  BodySetup setup;
  setup.step_s = 0.01;
  BodySpecification ball;
  ball.shape.radius_m = 0.1;
  ball.mass_kg = 1.0;
  ball.velocity_m_per_s = {0, 0, 1};
  setup.bodies.push_back(ball);
  return setup;
}

const std::vector<BodySpecification> balls = one_ball().bodies;
const Plausibility plausible({}, balls);

Timeline timeline;  ///< never opened

TEST(SerialExplicit, CallsEachSolverOncePerStepInThePapersOrder) {
  ConstantDragFluid fluid(0.0);
  PointMassBodies body(one_ball());
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::two_step, witness, timeline);
  fluid.before_exchange = [&](std::int64_t step) {
    EXPECT_EQ(step, fluid.exchanges);
    EXPECT_EQ(step, fluid.advances);
  };
  scheme.run(5, never);
  scheme.finish();
  EXPECT_EQ(fluid.exchanges, 5);
  EXPECT_EQ(fluid.advances, 5);
  EXPECT_EQ(witness.steps, (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(witness.finished_at, 5);
  EXPECT_EQ(scheme.step(), 5);
  EXPECT_DOUBLE_EQ(scheme.kinematics().position_m(2, 0), 0.05);
}

TEST(SerialExplicit, LetsDragSlowABodyDownExponentially) {
  ConstantDragFluid fluid(2.0);
  PointMassBodies body(one_ball());
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::none, witness, timeline);
  scheme.run(100, never);
  // Loads are held over a step, so the explicit scheme is of first order: v(n+1) = (1 − h c/m) v(n).
  EXPECT_NEAR(scheme.kinematics().velocity_m_per_s(2, 0), std::pow(1.0 - 0.01 * 2.0, 100), 1e-12);
  EXPECT_NEAR(scheme.kinematics().velocity_m_per_s(2, 0), std::exp(-2.0), 5e-3);
}

TEST(SerialExplicit, AppliesTheAverageOfTwoStepsLoads) {
  ConstantDragFluid fluid(2.0);
  PointMassBodies body(one_ball());
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::two_step, witness, timeline);
  scheme.run(3, never);
  EXPECT_EQ(witness.applied[0], 0.5 * witness.raw[0]);
  EXPECT_EQ(witness.applied[1], 0.5 * (witness.raw[0] + witness.raw[1]));
  EXPECT_EQ(witness.applied[2], 0.5 * (witness.raw[1] + witness.raw[2]));
}

TEST(SerialExplicit, DrivesABodyWithForcesSampledInsideTheStep) {
  BodySetup setup = one_ball();
  setup.bodies[0].velocity_m_per_s.setZero();
  setup.actuators = {{ActuatorKind::world_force, 0}};
  Signal sine;
  sine.kind = SignalKind::sinusoid;
  sine.amplitude = 1.0;
  sine.period_steps = 100;
  const DrivingProtocol driving({{setup.actuators[0], sine}});
  ConstantDragFluid fluid(0.0);
  PointMassBodies body(setup);
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::none, witness, timeline);
  scheme.run(25, never);
  // v(T/4) = ∫ sin(ωt) dt = 1/ω; a force held over each step would be off by 3 %.
  EXPECT_NEAR(scheme.kinematics().velocity_m_per_s(2, 0), 1.0 / (2.0 * std::numbers::pi), 1e-8);
}

TEST(SerialExplicit, GoesOnWhereItStopped) {
  ConstantDragFluid fluid(1.0);
  PointMassBodies body(one_ball());
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::two_step, witness, timeline);
  scheme.run(3, never);
  scheme.run(7, never);
  EXPECT_EQ(witness.steps.size(), 7U);
}

TEST(SerialExplicit, MeasuresTheTimeOfTheFluidAndOfTheBodiesSeparately) {
  ConstantDragFluid fluid(1.0);
  fluid.before_exchange = [](std::int64_t) { std::this_thread::sleep_for(std::chrono::milliseconds(2)); };
  PointMassBodies body(one_ball());
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::none, witness, timeline);
  scheme.run(10, never);
  EXPECT_GE(scheme.fluid_wait_s(), 10 * 2e-3);
  EXPECT_LT(scheme.body_wait_s(), scheme.fluid_wait_s());
}

TEST(SerialExplicit, PausesBeforeTheStepThatItIsAskedToPauseBefore) {
  ConstantDragFluid fluid(1.0);
  PointMassBodies body(one_ball());
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::two_step, witness, timeline);
  scheme.run(100, [](std::int64_t step) { return step == 3; });
  EXPECT_EQ(scheme.step(), 3);
  EXPECT_EQ(fluid.exchanges, 3);
  EXPECT_EQ(scheme.previous_loads().step, 2);
}

TEST(SerialExplicit, PassesTheErrorsOfItsSolversOn) {
  ConstantDragFluid fluid(1.0);
  fluid.before_exchange = [](std::int64_t step) {
    if (step == 4) throw SolverError("the flow diverged (a test). Do nothing.", 3, step);
  };
  PointMassBodies body(one_ball());
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::two_step, witness, timeline);
  EXPECT_THROW(scheme.run(100, never), SolverError);
  EXPECT_EQ(scheme.step(), 4);
}

TEST(SerialExplicit, EndsWithAMotionThatIsNotPlausible) {
  ConstantDragFluid fluid(0.0);
  BodySetup setup = one_ball();
  setup.bodies[0].velocity_m_per_s.z() = 1000.0;
  PointMassBodies body(setup);
  const DrivingProtocol driving({});
  Witness witness;
  SerialExplicit scheme(fluid, body, driving, plausible, LoadAveraging::none, witness, timeline);
  EXPECT_THROW(scheme.run(100, never), PeerFailed);
  EXPECT_EQ(scheme.step(), 0);
}

Loads loads_of(std::int64_t step, double force) {
  Loads loads;
  loads.step = step;
  loads.resize(2);
  loads.force_N.setConstant(force);
  loads.torque_N_m.setConstant(2.0 * force);
  return loads;
}

TEST(LoadAverage, AveragesTwoStepsAndCountsTheFirstOnce) {
  LoadAverage average(LoadAveraging::two_step);
  Loads applied;
  average.apply(loads_of(0, 4.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 2.0);
  EXPECT_EQ(applied.torque_N_m(2, 1), 4.0);
  average.apply(loads_of(1, 8.0), applied);
  EXPECT_EQ(applied.step, 1);
  EXPECT_EQ(applied.force_N(2, 1), 6.0);
  EXPECT_EQ(applied.torque_N_m(1, 0), 12.0);
  average.apply(loads_of(2, 0.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 4.0);
}

TEST(LoadAverage, RemovesAnOscillationFromStepToStep) {
  LoadAverage average(LoadAveraging::two_step);
  Loads applied;
  for (std::int64_t step = 0; step < 10; ++step) {
    average.apply(loads_of(step, step % 2 == 0 ? 1.0 : -1.0), applied);
    EXPECT_EQ(applied.force_N(0, 0), step == 0 ? 0.5 : 0.0);
  }
}

TEST(LoadAverage, PassesLoadsOnUnchangedWhenAskedTo) {
  LoadAverage average(LoadAveraging::none);
  Loads applied;
  average.apply(loads_of(0, 4.0), applied);
  average.apply(loads_of(1, 8.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 8.0);
  EXPECT_EQ(applied.step, 1);
}

TEST(LoadAverage, ContinuesWhereARestoredOneStopped) {
  LoadAverage one(LoadAveraging::two_step);
  Loads applied;
  one.apply(loads_of(0, 3.0), applied);
  LoadAverage other(LoadAveraging::two_step);
  other.restore(one.previous());
  other.apply(loads_of(1, 5.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 4.0);
}

}  // namespace
}  // namespace copepod::coupler
