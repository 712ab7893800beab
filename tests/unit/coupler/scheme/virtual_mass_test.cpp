
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "fakes.hpp"
#include "scheme/serial_explicit.hpp"

namespace copepod::coupler {
namespace {

constexpr double step_s = 0.001;
Timeline no_timeline;  ///< never opened

/// The load of a fluid that is at rest far away: drag, and the inertia of the fluid that moves with a body,
///   F(n) = −c V(n) − mₐ (V(n) − V(n−1))/Δt.
class AddedMassFluid final : public ConstantDragFluid {
 public:
  AddedMassFluid(double drag, double added_mass_kg) : ConstantDragFluid(drag), added_mass_kg_(added_mass_kg) {}

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    ConstantDragFluid::exchange(kinematics, loads);
    if (previous_m_per_s_.cols() == 0) previous_m_per_s_ = kinematics.velocity_m_per_s;
    loads.force_N -= added_mass_kg_ / step_s * (kinematics.velocity_m_per_s - previous_m_per_s_);
    previous_m_per_s_ = kinematics.velocity_m_per_s;
  }

 private:
  double added_mass_kg_;
  Eigen::Matrix3Xd previous_m_per_s_;
};

/// Keeps velocities of the first body, and the forces of fluid and drive on it, along z.
class MotionWitness final : public Observer {
 public:
  void observe(const StepRecord& record) override {
    velocity_m_per_s.push_back(record.kinematics.velocity_m_per_s(2, 0));
    force_N.push_back(record.applied.force_N(2, 0) + record.drive.force_N(2, 0));
  }
  void finish(const StepRecord& last) override { velocity_m_per_s.push_back(last.kinematics.velocity_m_per_s(2, 0)); }
  std::vector<double> velocity_m_per_s, force_N;
};

constexpr double light_kg = 0.01;  ///< where the fluid displaced has 1 kg
constexpr double drag = 2.0;       ///< [N s/m]
constexpr double added_mass_kg = 0.5;
constexpr double drive_N = 0.4;

/// A light ball that a constant force drives through AddedMassFluid, in the coupling scheme.
class DrivenBall {
 public:
  DrivenBall(double virtual_mass_kg, LoadAveraging averaging)
      : virtual_mass_(setup(), {virtual_mass_kg}, averaging),
        body_(virtual_mass_.enlarged(setup())),
        bodies_(setup().bodies),
        plausibility_({}, bodies_),
        driving_({{setup().actuators[0], constant()}}),
        scheme_(fluid_, body_, driving_, plausibility_, averaging, witness, no_timeline, virtual_mass_) {}

  void run(std::int64_t steps) {
    scheme_.run(steps, [](std::int64_t) { return false; });
    scheme_.finish();
  }

  MotionWitness witness;

 private:
  static BodySetup setup() {
    BodySetup setup;
    setup.step_s = step_s;
    setup.bodies.emplace_back();
    setup.bodies[0].shape.radius_m = 0.1;
    setup.bodies[0].mass_kg = light_kg;
    setup.actuators = {{ActuatorKind::world_force, 0}};
    return setup;
  }
  static Signal constant() {
    Signal signal;
    signal.kind = SignalKind::constant;
    signal.amplitude = drive_N;
    return signal;
  }

  VirtualMass virtual_mass_;
  AddedMassFluid fluid_{drag, added_mass_kg};
  PointMassBodies body_;
  std::vector<BodySpecification> bodies_;
  Plausibility plausibility_;
  DrivingProtocol driving_;
  SerialExplicit scheme_;
};

TEST(VirtualMass, KeepsABodyOfAHundredthOfTheFluidsDensityStable) {
  for (const LoadAveraging averaging : {LoadAveraging::none, LoadAveraging::two_step}) {
    EXPECT_THROW(DrivenBall(0.0, averaging).run(5000), PeerFailed);
    DrivenBall ball(1.0, averaging);
    ball.run(5000);
    EXPECT_NEAR(ball.witness.velocity_m_per_s.back(), drive_N / drag, 1e-9);
    for (const double velocity : ball.witness.velocity_m_per_s) EXPECT_LT(std::abs(velocity), 1.01 * drive_N / drag);
  }
}

// M (V(N) − V(0)) = Δt Σ F(n) − m (V(N) − V(N−1)): what the virtual mass still owes is that of one step.
TEST(VirtualMass, GivesTheTrueMotionInTheSumOverTheSteps) {
  DrivenBall ball(1.0, LoadAveraging::two_step);
  ball.run(20);
  const std::vector<double>& velocity = ball.witness.velocity_m_per_s;
  double impulse_N_s = 0.0;
  for (const double force_N : ball.witness.force_N) impulse_N_s += step_s * force_N;
  ASSERT_EQ(velocity.size(), 21U);
  EXPECT_NEAR(light_kg * velocity[20], impulse_N_s - 1.0 * (velocity[20] - velocity[19]), 1e-15);
  EXPECT_GT(std::abs(velocity[20] - velocity[19]), 1e-4);  // it owes something yet
}

TEST(VirtualMass, AcceleratesALightBodyAsItsAddedMassDoes) {
  DrivenBall ball(1.0, LoadAveraging::two_step);
  ball.run(240);
  const double exact = drive_N / drag * (1.0 - std::exp(-drag * 240 * step_s / (light_kg + added_mass_kg)));
  EXPECT_NEAR(ball.witness.velocity_m_per_s.back(), exact, 0.01 * exact);
}

/// A falling and tumbling capsule in two steps that follow each other.
class Capsule : public testing::Test {
 protected:
  Capsule() {
    setup.step_s = step_s;
    setup.gravity_m_per_s2 = {0, 0, -9.81};
    setup.bodies.resize(2);
    BodySpecification& capsule = setup.bodies[1];
    capsule.shape = {ShapeKind::capsule, 0.2, 0.5};
    capsule.mass_kg = 3.0;
    setup.bodies[0] = capsule;
    for (Kinematics* at : {&first, &second}) {
      at->resize(2);
      at->position_m.setZero();
      at->orientation_wxyz.setRandom();
      at->orientation_wxyz.colwise().normalize();
      at->velocity_m_per_s.setRandom();
      at->angular_velocity_rad_per_s.setRandom();
    }
    loads.resize(2);
    loads.force_N.setZero();
    loads.torque_N_m.setZero();
  }

  BodySetup setup;
  Kinematics first, second;
  Loads loads;
};

/// R J Rᵀ ω with J of the capsule, by Eigen's quaternions.
Eigen::Vector3d spin(const Eigen::Vector3d& moments, const Kinematics& at) {
  const Eigen::Vector4d q = at.orientation_wxyz.col(1);
  const Eigen::Quaterniond turned(q[0], q[1], q[2], q[3]);
  const Eigen::Vector3d along = turned * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d w = at.angular_velocity_rad_per_s.col(1);
  return moments[0] * w + (moments[2] - moments[0]) * along.dot(w) * along;
}

TEST_F(Capsule, ReceivesTheChangeOfItsVirtualMomentumLessItsVirtualWeight) {
  VirtualMass virtual_mass(setup, {0.0, 2.0}, LoadAveraging::none);
  virtual_mass.add_to(loads, first);
  EXPECT_EQ(loads.force_N.col(1), Eigen::Vector3d(0, 0, 2.0 * 9.81));
  EXPECT_TRUE(loads.torque_N_m.isZero(0.0));
  loads.force_N.setZero();
  virtual_mass.add_to(loads, second);
  const Eigen::Vector3d gained = second.velocity_m_per_s.col(1) - first.velocity_m_per_s.col(1);
  EXPECT_LT((loads.force_N.col(1) - (2.0 * gained / step_s - 2.0 * setup.gravity_m_per_s2)).norm(), 1e-11);
  const Eigen::Vector3d moments = inertia_tensor_kg_m2(setup.bodies[1].shape, 2.0).diagonal();
  const Eigen::Vector3d torque_N_m = (spin(moments, second) - spin(moments, first)) / step_s;
  EXPECT_LT((loads.torque_N_m.col(1) - torque_N_m).norm(), 1e-12);
  EXPECT_TRUE(loads.force_N.col(0).isZero(0.0));
  EXPECT_TRUE(loads.torque_N_m.col(0).isZero(0.0));
}

TEST_F(Capsule, KeepsItsWeightWhereNothingIsReturned) {
  VirtualMass kept(setup, {0.0, 2.0}, LoadAveraging::none, false);
  EXPECT_FALSE(kept.remembers());
  for (const Kinematics* at : {&first, &second}) {
    loads.force_N.setZero();
    kept.add_to(loads, *at);
    EXPECT_EQ(loads.force_N.col(1), Eigen::Vector3d(0, 0, 2.0 * 9.81));
    EXPECT_TRUE(loads.torque_N_m.isZero(0.0));
  }
}

TEST_F(Capsule, IsSentWithItsVirtualMass) {
  const BodySetup enlarged = VirtualMass(setup, {0.0, 2.0}, LoadAveraging::none).enlarged(setup);
  EXPECT_EQ(enlarged.bodies[0].mass_kg, 3.0);
  EXPECT_EQ(enlarged.bodies[1].mass_kg, 5.0);
}

TEST_F(Capsule, ContinuesBitForBitFromTheStateOfTheStepBefore) {
  VirtualMass one(setup, {0.0, 2.0}, LoadAveraging::none), other(setup, {0.0, 2.0}, LoadAveraging::none);
  one.add_to(loads, first);
  other.restore(one.previous());
  Loads of_one = loads, of_other = loads;
  one.add_to(of_one, second);
  other.add_to(of_other, second);
  EXPECT_EQ(of_one.force_N, of_other.force_N);
  EXPECT_EQ(of_one.torque_N_m, of_other.torque_N_m);
}

TEST_F(Capsule, WithoutVirtualMassKeepsItsLoadsAndNeedsNoState) {
  VirtualMass none(setup, {0.0, 0.0}, LoadAveraging::none);
  loads.force_N.setConstant(-0.0);
  none.add_to(loads, first);
  EXPECT_TRUE(std::signbit(loads.force_N(0, 1)));
  EXPECT_EQ(none.previous().bodies(), 0);
}

}  // namespace
}  // namespace copepod::coupler
