#include "geometry/actuator_loads.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace copepod {
namespace {

/// Two bodies askew, A turned by 90° about z, B by 0.7 rad about x.
class ActuatorLoads : public testing::Test {
 protected:
  ActuatorLoads() {
    state.resize(2);
    state.position_m << 0.3, 1.1, -0.2, 0.4, 0.5, -0.6;
    state.orientation_wxyz << std::sqrt(0.5), std::cos(0.35), 0, std::sin(0.35), 0, 0, std::sqrt(0.5), 0;
  }
  /// Of one actuator.
  Loads loads(const ActuatorSpecification& actuator, double value) {
    Loads drive;
    drive_loads({actuator}, Eigen::VectorXd::Constant(1, value), state, drive);
    return drive;
  }
  Kinematics state;
};

TEST_F(ActuatorLoads, OfAPairPushTheBodiesApartWithoutNetForceAndTorque) {
  const Loads plain = loads({ActuatorKind::pair_force, 0, 1}, 2.0);
  const Eigen::Vector3d along = (state.position_m.col(1) - state.position_m.col(0)).normalized();
  EXPECT_TRUE(plain.force_N.col(1).isApprox(2.0 * along));
  EXPECT_EQ(plain.force_N.col(0), -plain.force_N.col(1));
  EXPECT_TRUE(plain.torque_N_m.isZero(0.0));

  const Loads anchored =
      loads({ActuatorKind::pair_force, 0, 1, Eigen::Vector3d::UnitZ(), {0.1, 0, 0.2}, {0, -0.3, 0.1}}, 2.0);
  Eigen::Vector3d moment = anchored.torque_N_m.rowwise().sum();
  for (int i = 0; i < 2; ++i) moment += state.position_m.col(i).head<3>().cross(anchored.force_N.col(i).head<3>());
  EXPECT_EQ(anchored.force_N.col(0), -anchored.force_N.col(1));
  EXPECT_GT(anchored.torque_N_m.norm(), 0.1);
  EXPECT_LT(moment.norm(), 1e-15);
  // The end on A is at (0.3, −0.2, 0.5) + (0, 0.1, 0.2): its frame is turned by a right angle.
  const Eigen::Vector3d end_B =
      state.position_m.col(1) + rotation_matrix(state.orientation_wxyz.col(1)) * Eigen::Vector3d(0, -0.3, 0.1);
  EXPECT_TRUE(anchored.force_N.col(1).isApprox(2.0 * (end_B - Eigen::Vector3d(0.3, -0.1, 0.7)).normalized()));
}

TEST_F(ActuatorLoads, OfTheBodyTurnWithItAndThoseOfTheWorldDoNot) {
  EXPECT_TRUE(loads({ActuatorKind::body_force, 0, -1, {1, 0, 0}}, 3.0)
                  .force_N.isApprox((Eigen::Matrix3Xd(3, 2) << 0, 0, 3, 0, 0, 0).finished(), 1e-15));
  EXPECT_TRUE(loads({ActuatorKind::body_torque, 0, -1, {1, 0, 0}}, 3.0)
                  .torque_N_m.isApprox((Eigen::Matrix3Xd(3, 2) << 0, 0, 3, 0, 0, 0).finished(), 1e-15));
  EXPECT_EQ(loads({ActuatorKind::world_force, 1, -1, {1, 0, 0}}, 3.0).force_N,
            (Eigen::Matrix3Xd(3, 2) << 0, 3, 0, 0, 0, 0).finished());
  EXPECT_EQ(loads({ActuatorKind::world_torque, 1, -1, {1, 0, 0}}, 3.0).torque_N_m,
            (Eigen::Matrix3Xd(3, 2) << 0, 3, 0, 0, 0, 0).finished());
}

TEST_F(ActuatorLoads, NeedADirectionUnlessTheirValueIsZero) {
  state.position_m.col(1) = state.position_m.col(0);
  EXPECT_THROW(loads({ActuatorKind::pair_force, 0, 1}, 1.0), SolverError);
  EXPECT_TRUE(loads({ActuatorKind::pair_force, 0, 1}, 0.0).force_N.isZero(0.0));
}

}  // namespace
}  // namespace copepod
