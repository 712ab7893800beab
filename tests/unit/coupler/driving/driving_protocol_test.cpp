#include "driving/driving_protocol.hpp"

#include <array>

#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

DrivenActuator pair_force(int body_A, int body_B, double amplitude_N) {
  DrivenActuator driven;
  driven.actuator.body_A = body_A;
  driven.actuator.body_B = body_B;
  driven.signal.kind = SignalKind::sinusoid;
  driven.signal.amplitude = amplitude_N;
  driven.signal.period_steps = 8;
  return driven;
}

TEST(DrivingProtocol, SamplesEveryNodeOfAStep) {
  const DrivingProtocol driving({pair_force(0, 1, 2.0), pair_force(1, 2, 3.0)});
  const std::array<double, 3> nodes{0.0, 0.5, 1.0};
  Eigen::MatrixXd actuation;
  driving.sample(1, nodes, actuation);
  ASSERT_EQ(actuation.rows(), 2);
  ASSERT_EQ(actuation.cols(), 3);
  EXPECT_DOUBLE_EQ(actuation(0, 0), 2.0 * sine_of_turns(1.0 / 8.0));
  EXPECT_DOUBLE_EQ(actuation(1, 1), 3.0 * sine_of_turns(1.5 / 8.0));
  EXPECT_EQ(actuation(1, 2), 3.0);
}

TEST(DrivingProtocol, MovesJointsFromWhereTheyStart) {
  DrivenActuator driven = pair_force(0, 1, 2.0);
  driven.actuator.kind = ActuatorKind::joint_motion;
  driven.signal.lag_steps = -1.0;
  const DrivingProtocol driving({driven});
  Eigen::MatrixXd actuation;
  driving.sample(0, std::array{0.0, 1.0}, actuation);
  EXPECT_EQ(actuation(0, 0), 0.0);
  EXPECT_DOUBLE_EQ(actuation(0, 1), 2.0 - 2.0 * sine_of_turns(1.0 / 8.0));
}

/// A run that is resumed has the courses that actuators were steered to, and the signals of the others.
TEST(DrivingProtocol, ContinuesSteeredCourses) {
  const std::vector<DrivenActuator> drive{pair_force(0, 1, 2.0), pair_force(1, 2, 3.0), pair_force(0, 2, 4.0)};
  DrivingProtocol steered(drive), resumed(drive);
  steered.steer(0, 10, 5.0, 0);
  steered.steer(1, 10, 6.0, 8);
  ASSERT_EQ(steered.steered().size(), 3U);
  EXPECT_TRUE(steered.steered()[2].empty());
  for (std::size_t i = 0; i < 2; ++i) resumed.follow(i, steered.steered()[i]);
  Eigen::MatrixXd expected, found;
  for (const std::int64_t step : {10, 13, 18, 40}) {
    steered.sample(step, std::array{0.0, 0.5}, expected);
    resumed.sample(step, std::array{0.0, 0.5}, found);
    EXPECT_EQ(found, expected) << step;
    EXPECT_EQ(found(0, 0), 5.0) << step;
  }
  EXPECT_EQ(found(1, 0), 6.0);
}

TEST(DrivingProtocol, PushesPairsApartWithoutNetForceAtEveryStep) {
  const DrivingProtocol driving({pair_force(0, 1, 2.0), pair_force(1, 2, 3.0)});
  Kinematics kinematics;
  kinematics.resize(3);
  kinematics.position_m << 0, 1, 4, 0, 2, 2, 0, 2, 6;
  Eigen::MatrixXd actuation;
  Loads loads;
  for (std::int64_t step = 0; step < 8; ++step) {
    driving.sample(step, std::array{0.0}, actuation);
    driving.loads(kinematics, actuation, loads);
    EXPECT_LT(loads.force_N.rowwise().sum().norm(), 1e-15) << step;
    const Eigen::Vector3d along(1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0);
    EXPECT_LT((loads.force_N.col(0) + actuation(0, 0) * along).norm(), 1e-15) << step;
  }
}

}  // namespace
}  // namespace copepod::coupler
