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

Eigen::Matrix3Xd sampled(const DrivingProtocol& driving, std::int64_t step) {
  Eigen::Matrix3Xd force;
  driving.sample(step, start_of_step, force);
  return force;
}

DrivingProtocol paper_stroke() { return {stroke_terms(Eigen::Vector3d(0, 0, 1e-5), period, lag, 5, 0), 3}; }

TEST(DrivingProtocol, FollowsThePapersEquationsWithTheDelayOfItsText) {
  const DrivingProtocol driving = paper_stroke();
  for (const std::int64_t step : {0L, 100L, 7028L, 7029L, 7030L, 70000L, 140579L}) {
    const double t = 2.0 * std::numbers::pi * static_cast<double>(step) / period;
    const double shifted = 2.0 * std::numbers::pi * static_cast<double>(step - lag) / period;
    const double trailing = -1e-5 * std::sin(t);
    const double leading = step < lag ? 0.0 : 1e-5 * std::sin(shifted);
    const Eigen::Matrix3Xd force = sampled(driving, step);
    EXPECT_NEAR(force(2, 0), trailing, 1e-18) << step;
    EXPECT_NEAR(force(2, 1), -(trailing + leading), 1e-18) << step;
    EXPECT_NEAR(force(2, 2), leading, 1e-18) << step;
    EXPECT_TRUE(force.topRows(2).isZero(0.0));
  }
}

TEST(DrivingProtocol, SwitchesTheTrailingBeadOffAfterItsCyclesAndTheLeadingOneAfterTheLag) {
  const DrivingProtocol driving = paper_stroke();
  EXPECT_EQ(sampled(driving, 5 * period)(2, 0), 0.0);
  EXPECT_EQ(sampled(driving, 5 * period + 10)(2, 0), 0.0);
  EXPECT_NE(sampled(driving, 5 * period + 10)(2, 2), 0.0);
  EXPECT_TRUE(sampled(driving, 5 * period + lag).isZero(0.0));
}

TEST(DrivingProtocol, AddsUpToNoForceInEveryStep) {
  const DrivingProtocol driving = paper_stroke();
  for (std::int64_t step = 0; step < 6 * period; step += 997) {
    const Eigen::Matrix3Xd force = sampled(driving, step);
    EXPECT_EQ(force(2, 1), -(force(2, 0) + force(2, 2))) << step;
  }
}

TEST(DrivingProtocol, RepeatsItsBitsInEveryPeriod) {
  const DrivingProtocol driving({{0, Eigen::Vector3d(1, 2, 3), 1237, 17, 0, DrivingTerm::never}}, 1);
  const Eigen::Matrix3Xd first = sampled(driving, 100);
  EXPECT_EQ(first, sampled(driving, 100 + 1237));
  EXPECT_EQ(first, sampled(driving, 100 + 1237LL * 1'000'000'000));
}

TEST(DrivingProtocol, SamplesEveryNodeOfAStep) {
  const DrivingProtocol driving({{1, Eigen::Vector3d(0, 0, 2), 8, 0, 0, DrivingTerm::never}}, 2);
  const std::array<double, 3> nodes{0.0, 0.5, 1.0};
  Eigen::Matrix3Xd force;
  driving.sample(1, nodes, force);
  ASSERT_EQ(force.cols(), 6);
  EXPECT_DOUBLE_EQ(force(2, 1), 2.0 * std::sin(2.0 * std::numbers::pi * 1.0 / 8.0));
  EXPECT_DOUBLE_EQ(force(2, 3), 2.0 * std::sin(2.0 * std::numbers::pi * 1.5 / 8.0));
  EXPECT_EQ(force(2, 5), 2.0);
  EXPECT_EQ(force.col(0).norm() + force.col(2).norm() + force.col(4).norm(), 0.0);
}

TEST(DrivingProtocol, SwitchesAConstantForceAtStepsAndNotInsideThem) {
  const DrivingProtocol driving({{0, Eigen::Vector3d(1, 0, 0), 0, 0, 2, 4}}, 1);
  const std::array<double, 2> nodes{0.0, 1.0};
  Eigen::Matrix3Xd force;
  for (std::int64_t step = 0; step < 6; ++step) {
    driving.sample(step, nodes, force);
    const double expected = step >= 2 && step < 4 ? 1.0 : 0.0;
    EXPECT_EQ(force(0, 0), expected) << step;
    EXPECT_EQ(force(0, 1), expected) << step;
  }
}

TEST(DrivingProtocol, RefusesAForceOnABodyThatDoesNotExist) {
  EXPECT_THROW(DrivingProtocol({{3, Eigen::Vector3d::Zero(), 0, 0, 0, 1}}, 3), CaseError);
  EXPECT_THROW(DrivingProtocol({{-1, Eigen::Vector3d::Zero(), 0, 0, 0, 1}}, 3), CaseError);
  EXPECT_THROW(DrivingProtocol({{0, Eigen::Vector3d::Zero(), -5, 0, 0, 1}}, 3), CaseError);
}

}  // namespace
}  // namespace copepod::coupler
