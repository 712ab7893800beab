#include "driving/driving_protocol.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

constexpr std::array<double, 1> start_of_step{0.0};
constexpr std::int64_t period = 28116;
constexpr std::int64_t lag = 7029;

/// Values at the start of a step.
Eigen::VectorXd sampled(const DrivingProtocol& driving, std::int64_t step) {
  Eigen::MatrixXd actuation;
  driving.sample(step, start_of_step, actuation);
  return actuation.col(0);
}

/// Forces on a swimmer whose arms point along z.
Eigen::Matrix3Xd forces(const DrivingProtocol& driving, std::int64_t step) {
  Kinematics state;
  state.resize(3);
  state.position_m << 0, 0, 0, 0, 0, 0, 1e-5, 3e-5, 4e-5;
  Loads loads;
  driving.loads(state, sampled(driving, step), loads);
  return loads.force_N;
}

/// One world force along z.
DrivingProtocol one_term(const DrivingTerm& term) { return DrivingProtocol({{{ActuatorKind::world_force, 0}, term}}); }

DrivingProtocol paper_stroke() { return DrivingProtocol(stroke_terms(1e-5, period, lag, 5, 0)); }

TEST(DrivingProtocol, FollowsThePapersEquationsWithTheDelayOfItsText) {
  const DrivingProtocol driving = paper_stroke();
  for (const std::int64_t step : {0L, 100L, 7028L, 7029L, 7030L, 70000L, 140579L}) {
    const double t = 2.0 * std::numbers::pi * static_cast<double>(step) / period;
    const double shifted = 2.0 * std::numbers::pi * static_cast<double>(step - lag) / period;
    const double trailing = -1e-5 * std::sin(t);
    const double leading = step < lag ? 0.0 : 1e-5 * std::sin(shifted);
    const Eigen::Matrix3Xd force = forces(driving, step);
    EXPECT_NEAR(force(2, 0), trailing, 1e-18) << step;
    EXPECT_NEAR(force(2, 1), -(trailing + leading), 1e-18) << step;
    EXPECT_NEAR(force(2, 2), leading, 1e-18) << step;
    EXPECT_TRUE(force.topRows(2).isZero(0.0));
  }
}

TEST(DrivingProtocol, SwitchesTheTrailingArmOffAfterItsCyclesAndTheLeadingOneAfterTheLag) {
  const DrivingProtocol driving = paper_stroke();
  EXPECT_EQ(sampled(driving, 5 * period)[0], 0.0);
  EXPECT_EQ(sampled(driving, 5 * period + 10)[0], 0.0);
  EXPECT_NE(sampled(driving, 5 * period + 10)[1], 0.0);
  EXPECT_TRUE(sampled(driving, 5 * period + lag).isZero(0.0));
}

TEST(DrivingProtocol, AddsUpToNoForceInEveryStep) {
  const DrivingProtocol driving = paper_stroke();
  for (std::int64_t step = 0; step < 6 * period; step += 997) {
    const Eigen::Matrix3Xd force = forces(driving, step);
    EXPECT_EQ(force(2, 1), -(force(2, 0) + force(2, 2))) << step;
  }
}

TEST(DrivingProtocol, RepeatsItsBitsInEveryPeriod) {
  const DrivingProtocol driving = one_term({2.0, 1237, 17});
  const Eigen::VectorXd first = sampled(driving, 100);
  EXPECT_EQ(first, sampled(driving, 100 + 1237));
  EXPECT_EQ(first, sampled(driving, 100 + 1237LL * 1'000'000'000));
}

TEST(DrivingProtocol, SamplesEveryNodeOfAStep) {
  const DrivingProtocol driving({{{ActuatorKind::world_force, 0}, {0.0}}, {{ActuatorKind::world_force, 1}, {2.0, 8}}});
  const std::array<double, 3> nodes{0.0, 0.5, 1.0};
  Eigen::MatrixXd actuation;
  driving.sample(1, nodes, actuation);
  ASSERT_EQ(actuation.rows(), 2);
  ASSERT_EQ(actuation.cols(), 3);
  EXPECT_DOUBLE_EQ(actuation(1, 0), 2.0 * std::sin(2.0 * std::numbers::pi * 1.0 / 8.0));
  EXPECT_DOUBLE_EQ(actuation(1, 1), 2.0 * std::sin(2.0 * std::numbers::pi * 1.5 / 8.0));
  EXPECT_EQ(actuation(1, 2), 2.0);
  EXPECT_TRUE(actuation.row(0).isZero(0.0));
}

TEST(DrivingProtocol, SwitchesAConstantForceAtStepsAndNotInsideThem) {
  const DrivingProtocol driving = one_term({1.0, 0, 0, 2, 4});
  const std::array<double, 2> nodes{0.0, 1.0};
  Eigen::MatrixXd actuation;
  for (std::int64_t step = 0; step < 6; ++step) {
    driving.sample(step, nodes, actuation);
    const double expected = step >= 2 && step < 4 ? 1.0 : 0.0;
    EXPECT_EQ(actuation(0, 0), expected) << step;
    EXPECT_EQ(actuation(0, 1), expected) << step;
  }
}

TEST(DrivingProtocol, RefusesTimesThatRunBackwards) {
  EXPECT_THROW(one_term({1.0, -5}), CaseError);
  EXPECT_THROW(one_term({1.0, 0, 0, 5, 4}), CaseError);
}

}  // namespace
}  // namespace copepod::coupler
