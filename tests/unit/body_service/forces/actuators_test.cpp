#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "forces/forces.hpp"

namespace copepod::body {
namespace {

BodySetup three_bodies() { return setup_of({bead("a", {0, 0, 0}), bead("b", {1, 0, 0}), bead("c", {0, 2, 0})}, 1.0); }

TEST(Actuators, ApplyTheirOwnValuesToTheBodiesOfTheirBlock) {
  BodySetup setup = three_bodies();
  setup.actuators = {actuator_on(0, ActuatorKind::world_force, {0, 0, 1}), pair_force(1, 2),
                     actuator_on(2, ActuatorKind::world_torque, {0, 1, 0})};
  BlockState state;
  state.resize(2);
  state.position_m << 1, 0, 0, 2, 0, 0;
  state.orientation_wxyz << 1, 1, 0, 0, 0, 0, 0, 0;
  const BlockVectors resting = BlockVectors::Zero(3, 2);
  BlockVectors force = BlockVectors::Zero(3, 2);
  BlockVectors torque = BlockVectors::Zero(3, 2);
  const BodyBlock block = independent_blocks(setup, 1).at(1);
  CentreLines lines;
  lines.measure(block, state.position_m);
  Actuators(setup).add_loads({block, state, resting, lines, Eigen::Vector3d(7, 5, 3)}, force, torque);
  const Eigen::Vector3d along = Eigen::Vector3d(-1, 2, 0).normalized();
  EXPECT_TRUE(force.col(0).isApprox(-5.0 * along));
  EXPECT_EQ(force.col(1), -force.col(0));
  EXPECT_TRUE(torque.col(0).isZero(0.0));
  EXPECT_EQ(torque.col(1), Eigen::Vector3d(0, 3, 0));
}

TEST(Actuators, RefuseWhatIsNotAnActuatorOfTheirBodies) {
  const auto reason = [](const ActuatorSpecification& actuator) {
    BodySetup setup = three_bodies();
    setup.actuators = {actuator};
    return reason_of<CaseError>([&] { const Actuators refused(setup); });
  };
  EXPECT_TRUE(contains(reason(pair_force(0, 3)), "bodies 0 and 3 (there are 3"));
  EXPECT_TRUE(contains(reason(pair_force(1, 1)), "a pair needs two"));
  EXPECT_TRUE(contains(reason(pair_force(0, -1)), "bodies 0 and -1"));
  EXPECT_TRUE(contains(reason(actuator_on(-1, ActuatorKind::body_force, {0, 0, 1})), "bodies -1"));
  EXPECT_TRUE(contains(reason(actuator_on(0, ActuatorKind::body_force, {0, 0, 2})), "direction of length 2"));
}

}  // namespace
}  // namespace copepod::body
