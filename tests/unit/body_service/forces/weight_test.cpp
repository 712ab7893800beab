#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "forces/forces.hpp"

namespace copepod::body {
namespace {

/// What is added to a body's force.
Eigen::Vector3d weight_N(const BodySetup& setup, Eigen::Index body) {
  const BlockState state;
  const BlockVectors resting;
  BlockVectors force = BlockVectors::Zero(3, 1);
  BlockVectors torque = force;
  const BodyBlock block{body, 1, {}};
  Weight(setup).add_loads({block, state, resting, CentreLines(), Eigen::VectorXd()}, force, torque);
  return force;
}

/// Of a bead in a fluid, per volume.
Eigen::Vector3d weight_density(double density_kg_per_m3, double fluid_density_kg_per_m3,
                               const Eigen::Vector3d& gravity) {
  BodySetup setup = setup_of({bead("bead", {0, 0, 0})}, 1e-9);
  setup.bodies[0].mass_kg = density_kg_per_m3 * volume_m3(setup.bodies[0].shape);
  setup.gravity_m_per_s2 = gravity;
  setup.fluid_density_kg_per_m3 = fluid_density_kg_per_m3;
  return weight_N(setup, 0) / volume_m3(setup.bodies[0].shape);
}

TEST(Weight, IsThatOfGravityLessBuoyancy) {
  EXPECT_EQ(weight_density(2.0, 2.0, {0, 0, -10}), Eigen::Vector3d::Zero()) << "as dense as the fluid";
  EXPECT_TRUE(weight_density(5.0, 6.0, {0, 0, -10}).isApprox(Eigen::Vector3d(0, 0, 10))) << "lighter: upwards";
  EXPECT_TRUE(weight_density(5.0, 0.0, {1, 2, -10}).isApprox(Eigen::Vector3d(5, 10, -50))) << "in vacuum gravity alone";
}

TEST(Weight, IsAddedToTheBodiesOfABlock) {
  BodySetup setup = setup_of({bead("first", {0, 0, 0}), bead("heavy", {0, 0, 1}), capsule("light", {0, 0, 2})}, 1e-9);
  setup.bodies[1].mass_kg = 1e-11;
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.fluid_density_kg_per_m3 = 1360.0;
  const Weight weight(setup);
  const BodyBlock block{1, 2, {}};
  const BlockState state;
  const BlockVectors resting;
  BlockVectors force = BlockVectors::Constant(3, 2, 1e-11);
  BlockVectors torque = BlockVectors::Zero(3, 2);
  weight.add_loads({block, state, resting, CentreLines(), Eigen::VectorXd()}, force, torque);
  EXPECT_EQ(force(0, 0), 1e-11);
  EXPECT_DOUBLE_EQ(force(2, 0), 1e-11 - (1e-11 - 1360.0 * volume_m3(setup.bodies[1].shape)) * 9.81);
  EXPECT_EQ(force(2, 1), 1e-11 + weight_N(setup, 2)[2]);
  EXPECT_GT(weight_N(setup, 2)[2], 0.0) << "the paper's capsules are lighter than the fluid";
  EXPECT_TRUE(torque.isZero(0.0)) << "it acts at the centre of mass";
}

}  // namespace
}  // namespace copepod::body
