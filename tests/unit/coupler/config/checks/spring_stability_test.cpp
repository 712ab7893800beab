#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "config/checks/checks.hpp"

namespace copepod::coupler {
namespace {

constexpr Integrator euler = Integrator::semi_implicit_euler;
constexpr Integrator runge_kutta = Integrator::runge_kutta_4;

/// |(x, v)| after 2000 steps of ẍ = −a x − b ẋ from (1, 1).
double distance_after_many_steps(Integrator integrator, double a, double b, double h) {
  using State = Eigen::Vector2d;
  const auto rate = [&](const State& y) { return State(y[1], -a * y[0] - b * y[1]); };
  State y(1.0, 1.0);
  for (int step = 0; step < 2000; ++step) {
    if (integrator == Integrator::semi_implicit_euler) {
      y[1] += h * rate(y)[1];
      y[0] += h * y[1];
      continue;
    }
    const State k1 = rate(y);
    const State k2 = rate(y + 0.5 * h * k1);
    const State k3 = rate(y + 0.5 * h * k2);
    const State k4 = rate(y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return y.norm();
}

TEST(SpringStability, IsWhereOscillationsBeginToGrow) {
  for (const Integrator integrator : {euler, runge_kutta}) {
    for (const auto& [a, b] : {std::pair{1.0, 0.0}, {1.0, 0.3}, {1.0, 1.0}, {1.0, 5.0}, {0.0, 2.0}}) {
      const double h = largest_stable_step_s(integrator, a, b);
      EXPECT_LT(distance_after_many_steps(integrator, a, b, 0.99 * h), 20.0) << a << " " << b;
      EXPECT_GT(distance_after_many_steps(integrator, a, b, 1.01 * h), 1e6) << a << " " << b;
    }
  }
}

TEST(SpringStability, HasTheKnownLimitsWithoutDamping) {
  EXPECT_DOUBLE_EQ(largest_stable_step_s(euler, 4.0, 0.0), 1.0);
  EXPECT_NEAR(largest_stable_step_s(runge_kutta, 4.0, 0.0), std::sqrt(2.0), 1e-8);
  EXPECT_EQ(largest_stable_step_s(runge_kutta, 0.0, 0.0), std::numeric_limits<double>::infinity());
}

BodySpecification ball(const Eigen::Vector3d& position, double mass_kg) {
  BodySpecification body;
  body.shape = {ShapeKind::sphere, 1.0, 0.0};
  body.mass_kg = mass_kg;
  body.position_m = position;
  return body;
}

SpringSpecification spring(int A, int B, double stiffness_N_per_m) {
  SpringSpecification spring;
  spring.body_A = A;
  spring.body_B = B;
  spring.stiffness_N_per_m = stiffness_N_per_m;
  return spring;
}

/// ω² of the fastest mode, found from Euler's limit h ω = 2.
double fastest_square(const std::vector<BodySpecification>& bodies, const std::vector<SpringSpecification>& springs) {
  const double h = fastest_springs(bodies, springs, {}, {}, euler).together.largest_step_s;
  return 4.0 / (h * h);
}

TEST(FastestSpring, MovesTwoBodiesWithTheirReducedMass) {
  EXPECT_NEAR(fastest_square({ball({0, 0, 0}, 2.0), ball({3, 4, 0}, 0.5)}, {spring(0, 1, 3.0)}),
              3.0 * (1 / 2.0 + 1 / 0.5), 1e-12);
}

TEST(FastestSpring, OfASwimmerMovesItsMiddleAgainstBothEnds) {
  EXPECT_NEAR(fastest_square({ball({0, 0, 0}, 2.0), ball({0, 0, 5}, 2.0), ball({0, 0, 9}, 2.0)},
                             {spring(0, 1, 4.0), spring(1, 2, 4.0)}),
              3.0 * 4.0 / 2.0, 1e-12);
}

TEST(FastestSpring, AloneIsNoFasterThanAllTogether) {
  const FastestSprings fastest = fastest_springs({ball({0, 0, 0}, 2.0), ball({0, 0, 5}, 2.0), ball({0, 0, 9}, 2.0)},
                                                 {spring(0, 1, 4.0), spring(1, 2, 4.0)}, {}, {}, euler);
  EXPECT_NEAR(fastest.together.largest_step_s, 2.0 / std::sqrt(3.0 * 4.0 / 2.0), 1e-12);
  EXPECT_NEAR(fastest.alone.largest_step_s, 2.0 / std::sqrt(2.0 * 4.0 / 2.0), 1e-12);
}

TEST(FastestSpring, IsNotMadeFasterByOnesAcrossIt) {
  EXPECT_NEAR(fastest_square({ball({0, 0, 0}, 2.0), ball({0, 0, 5}, 2.0), ball({0, 5, 0}, 2.0)},
                             {spring(0, 1, 4.0), spring(0, 2, 4.0)}),
              2.0 * 4.0 / 2.0, 1e-12);
}

TEST(FastestSpring, TurnsABallThatItIsTiedToAtItsSide) {
  std::vector<BodySpecification> bodies{ball({0, 0, 0}, 2.0), ball({1, 0, 5}, 2.0)};
  bodies[1].motion = MotionKind::fixed;
  SpringSpecification beside = spring(0, 1, 4.0);
  beside.anchor_A_m = {1, 0, 0};
  EXPECT_NEAR(fastest_square(bodies, {beside}), 4.0 / 2.0 * (1.0 + 1.0 / 0.4), 1e-12);
}

TEST(FastestSpring, OfABodyOnAnAxisMovesItAlongThatOnly) {
  std::vector<BodySpecification> bodies{ball({0, 0, 0}, 2.0), ball({0, 3, 4}, 2.0)};
  bodies[0].motion = MotionKind::axis;
  bodies[0].axis = {0, 0, 1};
  bodies[1].motion = MotionKind::prescribed;
  EXPECT_NEAR(fastest_square(bodies, {spring(0, 1, 4.0)}), 4.0 / 2.0 * 0.64, 1e-12);
}

double square_of_bend(const std::vector<BodySpecification>& bodies, const BendSpecification& bend) {
  const double h = fastest_springs(bodies, {}, {bend}, {}, euler).together.largest_step_s;
  return 4.0 / (h * h);
}

// θ̈ = −κ (1/(m a²) + |t_a/a + t_c/c|²/m + 1/(m c²)) θ: in a straight row of equal arms 6 κ/(m l²), at a right
// angle 4 κ/(m l²).
TEST(FastestSpring, OfABendTurnsItsArms) {
  EXPECT_NEAR(square_of_bend({ball({0, 0, -5}, 2.0), ball({0, 0, 0}, 2.0), ball({0, 0, 5}, 2.0)}, {0, 1, 2, 3.0}),
              6.0 * 3.0 / (2.0 * 25.0), 1e-12);
  EXPECT_NEAR(square_of_bend({ball({0, 5, 0}, 2.0), ball({0, 0, 0}, 2.0), ball({0, 0, 5}, 2.0)}, {0, 1, 2, 3.0}),
              4.0 * 3.0 / (2.0 * 25.0), 1e-12);
}

TEST(FastestSpring, CountsBendsAfterTheSprings) {
  const std::vector<BodySpecification> bodies{ball({0, 0, -5}, 2.0), ball({0, 0, 0}, 2.0), ball({0, 0, 5}, 2.0)};
  EXPECT_EQ(fastest_springs(bodies, {spring(0, 1, 1.0)}, {{0, 1, 2, 1e3}}, {}, runge_kutta).together.spring, 1U);
  EXPECT_EQ(fastest_springs(bodies, {spring(0, 1, 1e3)}, {{0, 1, 2, 1.0}}, {}, runge_kutta).together.spring, 0U);
}

TEST(FastestSpring, IsTheOneThatLimitsTheStep) {
  const std::vector<BodySpecification> bodies{ball({0, 0, 0}, 1.0), ball({0, 0, 5}, 1.0), ball({0, 9, 0}, 1.0),
                                              ball({0, 9, 5}, 1.0)};
  EXPECT_EQ(fastest_springs(bodies, {spring(0, 1, 1.0), spring(2, 3, 2.0)}, {}, {}, runge_kutta).together.spring, 1U);
}

TEST(FastestSprings, HingesAreTorsionSpringsOfBothBodies) {
  const std::vector<BodySpecification> bodies{ball({0, 0, 0}, 2.0), ball({0, 0, 5}, 2.0)};
  const double inertia = inertia_tensor_kg_m2(bodies[0].shape, 2.0)(0, 0);
  JointSpecification hinge{JointKind::hinge, 0, 1};
  hinge.stiffness = 3.0;
  const FastestSprings fastest = fastest_springs(bodies, {}, {}, {hinge}, runge_kutta);
  EXPECT_NEAR(fastest.together.largest_step_s, std::sqrt(8.0 / (2.0 * 3.0 / inertia)), 1e-6);
  EXPECT_TRUE(std::isinf(fastest.alone.largest_step_s)) << "joints may make it slower";
  hinge.body_B = -1;
  EXPECT_NEAR(fastest_springs(bodies, {}, {}, {hinge}, runge_kutta).together.largest_step_s,
              std::sqrt(8.0 / (3.0 / inertia)), 1e-6);
}

}  // namespace
}  // namespace copepod::coupler
