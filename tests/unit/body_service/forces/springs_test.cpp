#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "forces/forces.hpp"
#include "geometry/rotation.hpp"

namespace copepod::body {
namespace {

TEST(SpringForce, PullsItsEndsTogetherWhenStretched) {
  const SpringSpecification spring{0, 1, 3.0, 0.0, 2.0};
  const Eigen::Vector3d f = spring_force(spring, {0, 0, 5}, {0, 0, 0});
  EXPECT_EQ(f, Eigen::Vector3d(0, 0, 9));
}

TEST(SpringForce, PushesItsEndsApartWhenCompressed) {
  const SpringSpecification spring{0, 1, 3.0, 0.0, 2.0};
  EXPECT_EQ(spring_force(spring, {1, 0, 0}, {0, 0, 0}), Eigen::Vector3d(-3, 0, 0));
}

TEST(SpringForce, DampsTheRateOfItsLength) {
  const SpringSpecification spring{0, 1, 0.0, 7.0, 2.0};
  EXPECT_EQ(spring_force(spring, {0, 4, 0}, {0, 2, 0}), Eigen::Vector3d(0, 14, 0));
}

TEST(SpringForce, DoesNotBrakeMotionAcrossIt) {
  const SpringSpecification spring{0, 1, 0.0, 7.0, 2.0};
  EXPECT_EQ(spring_force(spring, {0, 4, 0}, {3, 0, -5}), Eigen::Vector3d::Zero());
}

/// Two tilted capsules with springs at off-centre anchors and a third body between.
class AnchoredSprings : public testing::Test {
 protected:
  AnchoredSprings() {
    setup_ = setup_of({bead("a", {0, 0, 0}), bead("b", {1, 0, 0}), bead("c", {0, 2, 0})}, 1.0);
    SpringSpecification spring;
    spring.body_A = 0;
    spring.body_B = 2;
    spring.stiffness_N_per_m = 3.0;
    spring.damping_N_s_per_m = 0.5;
    spring.rest_length_m = 0.7;
    spring.anchor_A_m = {0.1, -0.2, 0.3};
    spring.anchor_B_m = {-0.3, 0.1, 0.2};
    setup_.springs = {spring};
    state_.resize(3);
    state_.position_m << 0, 1, 0.2, 0, 0, 2, 0, 0, 0.5;
    state_.orientation_wxyz << 0.3, 1, 0.8, -0.5, 0, 0.1, 0.7, 0, -0.4, 0.4, 0, 0.2;
    state_.orientation_wxyz.colwise().normalize();
    state_.velocity_m_per_s << 1, 0, -2, 0.5, 0, 0.3, -1, 0, 0.2;
    angular_velocity_ << 0.4, 0, 1, -1, 0, 2, 0.2, 0, -0.6;
    force_.setZero(3, 3);
    torque_.setZero(3, 3);
  }

  void add_loads() {
    const std::vector<BodyBlock> blocks = independent_blocks(setup_, 1);  // that of the springs is the last
    CentreLines lines;
    lines.measure(blocks.back(), state_.position_m);
    Springs(setup_).add_loads({blocks.back(), state_, angular_velocity_, lines, Eigen::VectorXd()}, force_, torque_);
  }

  BodySetup setup_;
  BlockState state_;
  BlockVectors angular_velocity_{3, 3};
  BlockVectors force_;
  BlockVectors torque_;
};

TEST_F(AnchoredSprings, ConserveMomentumAndAngularMomentum) {
  add_loads();
  Eigen::Vector3d moment = torque_.rowwise().sum();
  for (int i = 0; i < 3; ++i) {
    moment += state_.position_m.col(i).head<3>().cross(force_.col(i).head<3>());
  }
  EXPECT_GT(force_.norm(), 1.0);
  EXPECT_GT(torque_.norm(), 0.1);
  EXPECT_LT(force_.rowwise().sum().norm(), 1e-15);
  EXPECT_LT(moment.norm(), 1e-15);
}

TEST_F(AnchoredSprings, DrawThePowerThatTheirDamperAndPotentialTake) {
  // Power of the loads on the bodies = −d/dt (k (l − l₀)²/2) − γ (dl/dt)², with l and dl/dt by differences.
  const auto length = [&](double time) {
    const auto anchor = [&](int body, const Eigen::Vector3d& anchor_B) -> Eigen::Vector3d {
      const Eigen::Vector3d turn = time * angular_velocity_.col(body);
      return state_.position_m.col(body) + time * state_.velocity_m_per_s.col(body) +
             rotation_matrix(rotated(turn, state_.orientation_wxyz.col(body))) * anchor_B;
    };
    return (anchor(2, setup_.springs[0].anchor_B_m) - anchor(0, setup_.springs[0].anchor_A_m)).norm();
  };
  const double h = 1e-5;
  const double rate = (length(h) - length(-h)) / (2 * h);
  const double expected = -3.0 * (length(0) - 0.7) * rate - 0.5 * rate * rate;
  add_loads();
  const double power =
      force_.cwiseProduct(state_.velocity_m_per_s).sum() + torque_.cwiseProduct(angular_velocity_).sum();
  EXPECT_NEAR(power, expected, 1e-8);
}

TEST_F(AnchoredSprings, DoNotBrakeARigidRotation) {
  setup_.springs[0].stiffness_N_per_m = 0.0;
  const Eigen::Vector3d w(0.3, -0.8, 0.5);
  angular_velocity_.colwise() = w;
  for (int i = 0; i < 3; ++i) state_.velocity_m_per_s.col(i) = w.cross(state_.position_m.col(i).head<3>());
  add_loads();
  EXPECT_LT(force_.norm(), 1e-15);
  EXPECT_LT(torque_.norm(), 1e-15);
}

TEST_F(AnchoredSprings, NameTheBodiesWhoseAnchorsCoincide) {
  state_.orientation_wxyz.col(0) << 1, 0, 0, 0;
  state_.orientation_wxyz.col(2) << 1, 0, 0, 0;
  setup_.springs[0].anchor_A_m = {0, 0, 0.5};
  setup_.springs[0].anchor_B_m = {0, 0, -0.5};
  state_.position_m.col(0).setZero();
  state_.position_m.col(2) << 0, 0, 1;
  const std::string reason = reason_of<SolverError>([&] { add_loads(); });
  EXPECT_TRUE(contains(reason, "'a' and 'c' coincide"));
}

TEST_F(AnchoredSprings, WithAnchorsAtTheCentresEqualPlainSprings) {
  setup_.springs[0].anchor_A_m.setZero();
  setup_.springs[0].anchor_B_m.setZero();
  add_loads();
  const BlockVectors plain = force_;
  EXPECT_TRUE(torque_.isZero(0.0));
  setup_.springs[0].anchor_A_m = {0, 0, 1e-12};
  force_.setZero();
  add_loads();
  EXPECT_TRUE(force_.isApprox(plain, 1e-10));
}

TEST_F(AnchoredSprings, WithoutAnchorsActOnWhatTheLineBetweenTheirBodiesIsFor) {
  // The line 0-2 serves two springs, the line 2-1 another one; each must act on its own bodies in its own direction.
  setup_.springs = {{0, 2, 3.0, 0.5, 0.7}, {2, 1, 2.0, 0.1, 0.3}, {0, 2, 1.0, 0.0, 0.2}};
  add_loads();
  BlockVectors expected = BlockVectors::Zero(3, 3);
  for (const SpringSpecification& spring : setup_.springs) {
    const auto between = [&](const BlockVectors& vectors) -> Eigen::Vector3d {
      return vectors.col(spring.body_B) - vectors.col(spring.body_A);
    };
    const Eigen::Vector3d force = spring_force(spring, between(state_.position_m), between(state_.velocity_m_per_s));
    expected.col(spring.body_A) += force;
    expected.col(spring.body_B) -= force;
  }
  EXPECT_EQ(force_, expected);
  EXPECT_TRUE(torque_.isZero(0.0));
}

TEST_F(AnchoredSprings, ActOnTheSameBodiesInABlockThatBeginsLater) {
  add_loads();
  const BlockVectors force = force_;
  const BlockVectors torque = torque_;
  setup_.bodies.insert(setup_.bodies.begin(), bead("before", {9, 9, 9}));
  setup_.springs[0].body_A += 1;
  setup_.springs[0].body_B += 1;
  force_.setOnes();
  torque_.setOnes();
  add_loads();
  EXPECT_EQ(force_, (BlockVectors::Ones(3, 3) + force).eval()) << "added to the sums";
  EXPECT_EQ(torque_, (BlockVectors::Ones(3, 3) + torque).eval());
}

TEST(Springs, RefuseWrongBodiesAndNegativeProperties) {
  const auto refusal = [](const std::function<void(SpringSpecification&)>& spoil) {
    BodySetup setup = setup_of({bead("a", {0, 0, 0}), bead("b", {0, 0, 1})}, 1.0);
    SpringSpecification spring;
    spring.body_B = 1;
    spoil(spring);
    setup.springs = {{}, spring};
    setup.springs[0].body_B = 1;
    return reason_of<CaseError>([&] { const Springs springs(setup); });
  };
  EXPECT_TRUE(contains(refusal([](auto& s) { s.body_B = 2; }), "spring 1 connects bodies 0 and 2"));
  EXPECT_TRUE(contains(refusal([](auto& s) { s.body_A = -1; }), "spring 1 connects bodies -1"));
  EXPECT_TRUE(contains(refusal([](auto& s) { s.body_A = 1; }), "to itself"));
  EXPECT_TRUE(contains(refusal([](auto& s) { s.stiffness_N_per_m = -1; }), "negative stiffness"));
  EXPECT_TRUE(contains(refusal([](auto& s) { s.damping_N_s_per_m = -1; }), "negative stiffness, damping"));
  EXPECT_TRUE(contains(refusal([](auto& s) { s.rest_length_m = -1; }), "rest length"));
}

}  // namespace
}  // namespace copepod::body
