#include <cmath>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "driving/driving_protocol.hpp"
#include "driving/prescribed_bodies.hpp"
#include "fakes.hpp"

namespace copepod::coupler {
namespace {

const std::set<std::string> required{"shape:sphere", "actuator:pair_force"};

TEST(MustBeLowered, DoesNotHoldForJointsThatMove) {
  EXPECT_TRUE(must_be_lowered({"actuator:pair_force"}, {"actuator:world_force"}));
  EXPECT_FALSE(must_be_lowered({"actuator:pair_force", "actuator:joint_motion"}, {"actuator:world_force"}));
}

TEST(MustBeLowered, WhereOnlyWorldForcesAreThere) {
  EXPECT_FALSE(must_be_lowered(required, {"shape:sphere", "actuator:pair_force", "actuator:world_force"}));
  EXPECT_TRUE(must_be_lowered(required, {"shape:sphere", "actuator:world_force"}));
  EXPECT_FALSE(must_be_lowered(required, {"shape:sphere"}));
  EXPECT_FALSE(must_be_lowered(required, {"actuator:pair_force", "actuator:world_force"}));
  EXPECT_FALSE(must_be_lowered(required, {"shape:sphere", "actuator:world_force", "neglects:actuator"}));
}

/// Two spheres that move past each other.
BodySetup turning_pair() {
  BodySetup setup;
  setup.step_s = 0.01;
  setup.bodies.resize(2);
  for (int i : {0, 1}) {
    const double side = i == 0 ? -1.0 : 1.0;
    setup.bodies[static_cast<std::size_t>(i)].mass_kg = 1.0;
    setup.bodies[static_cast<std::size_t>(i)].position_m = {side, 0, 0};
    setup.bodies[static_cast<std::size_t>(i)].velocity_m_per_s = {0, side, 0};
  }
  setup.actuators = {{ActuatorKind::pair_force, 0, 1}};
  return setup;
}

TEST(Lowered, SetupHasOneWorldForcePerAxisAndDrivenBody) {
  BodySetup setup = turning_pair();
  setup.bodies.resize(3);
  setup.actuators.push_back({ActuatorKind::body_force, 1});
  setup.actuators.push_back({ActuatorKind::body_torque, 2});
  const BodySetup without = lowered(setup);
  ASSERT_EQ(without.actuators.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(without.actuators[i].kind, i < 6 ? ActuatorKind::world_force : ActuatorKind::world_torque);
    EXPECT_EQ(without.actuators[i].body_A, static_cast<int>(i / 3));
    EXPECT_EQ(without.actuators[i].direction, Eigen::Vector3d::Unit(static_cast<Eigen::Index>(i % 3)));
  }
  for (const int body : {0, 1}) {  // an anchor turns its body
    ActuatorSpecification anchored{ActuatorKind::pair_force, 0, 1};
    (body == 0 ? anchored.anchor_A_m : anchored.anchor_B_m) = {0.1, 0, 0};
    setup.actuators = {anchored};
    const std::vector<ActuatorSpecification> actuators = lowered(setup).actuators;
    ASSERT_EQ(actuators.size(), 9U);
    EXPECT_EQ(actuators[8].kind, ActuatorKind::world_torque);
    EXPECT_EQ(actuators[8].body_A, body);
  }
}

/// Distance of the two spheres' relative position from that of a run whose body solver has the actuators.
double deviation_m(double step_s) {
  BodySetup setup = turning_pair();
  setup.step_s = step_s;
  PointMassBodies followed(setup);
  LoweredBodies served(std::make_unique<PointMassBodies>(lowered(setup)), setup);
  Kinematics exact, approximate;
  followed.kinematics(exact);
  served.kinematics(approximate);
  AppliedLoads applied;
  applied.hydrodynamic.resize(2);
  applied.hydrodynamic.force_N.setZero();
  applied.hydrodynamic.torque_N_m.setZero();
  applied.actuation.setConstant(1, 3, 0.5);
  for (double time_s = 0.5 * step_s; time_s < 1.0; time_s += step_s) {
    applied.hydrodynamic.step = exact.step;
    followed.step(applied, exact);
    served.step(applied, approximate);
  }
  EXPECT_LT((approximate.velocity_m_per_s.rowwise().sum()).norm(), 1e-14) << "a net force";
  return (approximate.position_m - exact.position_m).norm();
}

TEST(LoweredBodies, FollowTheActuatorsToFirstOrderInTheStep) {
  const double coarse = deviation_m(0.01);
  EXPECT_GT(coarse, 1e-5);
  EXPECT_LT(coarse, 1e-2);
  EXPECT_NEAR(coarse / deviation_m(0.005), 2.0, 0.1);
}

}  // namespace
}  // namespace copepod::coupler
