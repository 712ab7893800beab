#include "lattice_boltzmann/kernel/link_formula.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "lattice_boltzmann/lattice/d3q19.hpp"

namespace copepod::fluid {
namespace {

/// A link in direction α; its other numbers are 0.
Link<double> link_in(int alpha) {
  Link<double> link;
  std::ranges::copy(d3q19::velocity[static_cast<std::size_t>(alpha)], link.e);
  link.weight = d3q19::weight(alpha);
  return link;
}

TEST(BounceBack, SendsBackWhatMeetsAWallAtRest) {
  Link<double> link = link_in(5);
  link.leaving = 0.0123;
  link.density = 1.1;
  EXPECT_EQ(BounceBack().returning(link), 0.0123);
}

TEST(BounceBack, AMovingWallTakesMomentumFromWhatFollowsIt) {
  for (const auto& [alpha, weight] : {std::pair(1, 1.0 / 18.0), std::pair(7, 1.0 / 36.0)}) {
    Link<double> link = link_in(alpha);
    link.leaving = 0.01;
    link.density = 1.1;
    link.e_dot_u_w = 0.05;
    EXPECT_NEAR(BounceBack().returning(link), 0.01 - 6.0 * weight * 1.1 * 0.05, 1e-17);
  }
}

/// A link along which the fluid shears: E ± 3 w e·u(s), u(s) = u + s u' with the wall at s = q.
Link<double> sheared(double q, double e_dot_u, double slope) {
  const double even = 0.01;
  Link<double> link = link_in(7);
  link.leaving = even + 3.0 * link.weight * e_dot_u;
  link.density = 1.0;
  link.e_dot_u_w = e_dot_u + q * slope;
  link.wall_distance = q;
  link.inward = even - 3.0 * link.weight * e_dot_u;
  link.behind = even + 3.0 * link.weight * (e_dot_u - slope);
  link.e_dot_j = e_dot_u;
  return link;
}

/// A collision with relaxation times τ⁺ and τ⁻ and a force along x.
CollisionConstants<double> two_times(double even_time, double odd_time, double force = 0.0) {
  return {0.5 / even_time, 0.5 / odd_time, {force, 0.0, 0.0}};
}

// What would leave x_f + e_α in direction ᾱ if the flow continued there.
TEST(LinkFormulas, AreExactInAShearedFlowWhereverTheWallIs) {
  for (const double q : {0.0, 0.1, 0.3, 0.5, 0.7, 1.0}) {
    const Link<double> link = sheared(q, 0.02, 0.005);
    const double expected = 0.01 - 3.0 / 36.0 * (0.02 + 0.005);
    EXPECT_NEAR(CentralLinear().returning(link), expected, 1e-17) << q;
    EXPECT_NEAR(Interpolated().returning(link), expected, 1e-17) << q;
    for (const double odd_time : {1.2, 1.0})
      EXPECT_NEAR(Parabolic(two_times(0.8, odd_time)).returning(link), expected, 1e-17) << q;
    EXPECT_EQ(std::abs(BounceBack().returning(link) - expected) < 1e-17, q == 0.5) << q;
  }
}

// The steady state of any two relaxation times where 3 w e·u is a + b s + c s²/2 along the link, and a body force of S
// balances the gradient of pressure: the even half changes by b in a collision, the odd half by S − Λ⁺ c.
TEST(Parabolic, IsExactInAParabolicFlowAtEveryRelaxationTime) {
  const double w = d3q19::weight(7);
  const double a = 0.001, b = 0.0004, c = -0.0003, source = 0.00007;
  for (const auto& [even_time, odd_time] :
       {std::pair(0.51, 19.25), {0.6, 2.375}, {2.0, 0.625}, {2.0, 2.4}, {0.67, 0.67}, {0.75, 0.75}})
    for (const double q : {0.0, 0.2, 0.5, 1.0}) {
      const double change = (even_time - 0.5) * c - source;
      const double even = 0.01 - even_time * b;
      const double odd = a - 0.5 * source + odd_time * (change + source);
      Link<double> link = link_in(7);
      link.leaving = even + b + odd - change;
      link.density = 1.0;
      link.e_dot_u_w = (a + b * q + 0.5 * c * q * q) / (3.0 * w);
      link.wall_distance = q;
      link.inward = even + b - odd + change;
      link.behind = even + odd;
      link.e_dot_j = (a + 0.5 * source) / (3.0 * w);
      const Parabolic parabolic(two_times(even_time, odd_time, source / (3.0 * w)));
      EXPECT_NEAR(parabolic.returning(link), even - odd, 1e-15) << even_time << ' ' << odd_time << ' ' << q;
    }
}

/// Part of a deviation of f⁻ from its equilibrium that comes back from a surface at x_f + q e, after the collision.
double returned_part(double even_time, double odd_time, double q) {
  Link<double> link = link_in(7);
  link.leaving = (odd_time - 1.0) / odd_time;
  link.inward = -link.leaving;
  link.wall_distance = q;
  return Parabolic(two_times(even_time, odd_time)).returning(link);
}

// Two parts or more grow from step to step: bgk, with 2.9 at τ = 0.6667, diverged below 0.72.
TEST(Parabolic, ReturnsNoMoreOfADeviationWithBgkThanStaysStable) {
  for (const double time : {0.51, 0.52, 0.55, 0.6, 2.0 / 3.0, 0.7, 0.72, 0.78, 1.5})
    for (const double q : {0.7, 0.8, 1.0}) EXPECT_LT(std::abs(returned_part(time, time, q)), 1.67) << time << ' ' << q;
}

// (−1)^(x+t) j, which changes its sign from cell to cell and, where it is conserved, from step to step.
TEST(LinkFormulas, ReturnStaggeredMomentumAsItCameExceptForTheParabolic) {
  for (const double q : {0.0, 0.3, 0.5, 1.0}) {
    Link<double> link = link_in(7);
    link.leaving = 0.01;
    link.wall_distance = q;
    link.inward = link.behind = -0.01;
    link.e_dot_j = 0.01 / (3.0 * link.weight);
    EXPECT_NEAR(CentralLinear().returning(link), 0.01, 1e-17) << q;
    EXPECT_EQ(BounceBack().returning(link), 0.01);
    for (const double even_time : {0.55, 0.8, 1.0, 2.0}) {
      const double odd_time = 0.5 + 3.0 / 16.0 / (even_time - 0.5);
      EXPECT_LT(std::abs(Parabolic(two_times(even_time, odd_time)).returning(link)), 0.0081) << even_time << ' ' << q;
      EXPECT_LE(std::abs(Parabolic(two_times(even_time, even_time)).returning(link)), 0.010001) << even_time;
    }
  }
}

}  // namespace
}  // namespace copepod::fluid
