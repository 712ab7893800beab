#include "config/placement/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "config/sections/sections.hpp"

namespace copepod::coupler {
namespace {

BodySpecification capsule(const Eigen::Vector3d& position, const Eigen::Vector4d& q, double radius, double length) {
  BodySpecification body;
  body.shape = {ShapeKind::capsule, radius, length};
  body.position_m = position;
  body.orientation_wxyz = q;
  return body;
}

const Eigen::Vector4d upright(1, 0, 0, 0);
const Eigen::Vector4d along_x(std::sqrt(0.5), 0, std::sqrt(0.5), 0);
const Eigen::Vector4d along_y(std::sqrt(0.5), -std::sqrt(0.5), 0, 0);

TEST(Geometry, TurnsTheBodysAxisIntoTheWorld) {
  EXPECT_TRUE(body_axis(capsule({0, 0, 0}, upright, 1, 2)).isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE(body_axis(capsule({0, 0, 0}, along_x, 1, 2)).isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE(body_axis(capsule({0, 0, 0}, along_y, 1, 2)).isApprox(Eigen::Vector3d(0, 1, 0)));
}

TEST(Geometry, MeasuresHalfExtents) {
  EXPECT_TRUE(half_extents_m(capsule({0, 0, 0}, along_x, 1, 4)).isApprox(Eigen::Vector3d(3, 1, 1)));
}

/// Bodies at pseudo-random places of a cube; every tenth is large.
std::vector<BodySpecification> scattered(std::size_t count, double cube_m) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0.0, cube_m);
  std::vector<BodySpecification> bodies;
  for (std::size_t i = 0; i < count; ++i)
    bodies.push_back(capsule({place(random), place(random), place(random)}, along_x, i % 10 == 0 ? 3.0 : 0.5, 1.0));
  return bodies;
}

using Pairs = std::vector<BodyPair>;

/// Those of `candidates` whose surfaces are less than `reach` apart, seen across periodic faces.
Pairs within(const std::vector<BodySpecification>& bodies, const Pairs& candidates, double period, double reach) {
  Pairs close;
  for (const auto& [a, b] : candidates) {
    Eigen::Vector3d shift = bodies[a].position_m - bodies[b].position_m;
    if (period > 0.0)
      shift = period * (shift / period).array().round();
    else
      shift.setZero();
    BodySpecification shifted = bodies[b];
    shifted.position_m += shift;
    if (surface_distance_m(bodies[a], shifted) < reach) close.emplace_back(a, b);
  }
  return close;
}

TEST(NearPairs, MissNoneThatIsCloseEnough) {
  const auto bodies = scattered(400, 60.0);
  Pairs all;
  const int count = static_cast<int>(bodies.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) all.emplace_back(a, b);
  }
  for (const double period : {0.0, 60.0}) {
    const Pairs near = near_pairs(bodies, {period, period, period}, 0.7);
    EXPECT_EQ(within(bodies, near, period, 0.7), within(bodies, all, period, 0.7)) << period;
    EXPECT_LT(near.size(), all.size() / 10);
  }
}

TEST(NearPairs, GrowWithTheNumberOfBodies) {
  const auto count = [](std::size_t bodies, double cube_m) {
    return static_cast<double>(near_pairs(scattered(bodies, cube_m), {0, 0, 0}, 0.0).size());
  };
  EXPECT_LT(count(8000, 200.0), 12.0 * count(1000, 100.0));  // 64 times as many pairs in all
}

TEST(NearPairs, IncludeOneBodyThatSpansTheDomain) {
  auto bodies = scattered(1000, 100.0);
  bodies.push_back(capsule({50, 50, 50}, upright, 1e6, 0.0));
  const Pairs near = near_pairs(bodies, {0, 0, 0}, 0.0);
  const auto with_large = std::count_if(near.begin(), near.end(), [](const auto& pair) { return pair.second == 1000; });
  EXPECT_EQ(with_large, 1000);
}

TEST(NearPairs, AcceptAbsurdLengths) {
  std::vector<BodySpecification> bodies = scattered(2, 1.0);
  bodies[0].shape.radius_m = 1e308;
  bodies[1].shape.radius_m = 5e-324;
  bodies[1].position_m.x() = -1e308;
  EXPECT_LE(near_pairs(bodies, {1e300, 0, 1e-300}, 0.0).size(), 1U);
}

TEST(Geometry, MeasuresDistancesBetweenCapsules) {
  const auto at = [&](const Eigen::Vector3d& p, const Eigen::Vector4d& q) { return capsule(p, q, 1, 4); };
  // Side by side, end to end, crossed, a T, and skew beyond both ends.
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({5, 0, 0}, upright)), 3.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 0, 9}, upright)), 3.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 4, 0}, along_x)), 2.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 0, 5}, along_x)), 1.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 5, 6}, along_y)), 5.0 - 2.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({1, 0, 0}, upright)), -1.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({5, 0, 0}, along_y)), 3.0, 1e-12);
}

TEST(Geometry, MeasuresDistancesBetweenSpheresAndCapsules) {
  BodySpecification sphere;
  sphere.shape = {ShapeKind::sphere, 1.0, 0.0};
  sphere.position_m = {3, 0, 1};
  EXPECT_NEAR(surface_distance_m(sphere, capsule({0, 0, 0}, upright, 1, 4)), 1.0, 1e-12);
}

/// A case of one three-bead swimmer: two capsules around a sphere.
Case with_swimmer(const std::string& axis, const std::string& orientations) {
  const auto comma = orientations.find(',');
  const auto capsule_bead = [](const std::string& orientation) {
    return "{shape: capsule, radius_m: 4, length_m: 8, orientation: " + orientation + "}";
  };
  const Document document = Document::parse(
      "{name: s, center_m: [50, 50, 100], axis: " + axis + ", beads: [" + capsule_bead(orientations.substr(0, comma)) +
          ", {radius_m: 4}, " + capsule_bead(orientations.substr(comma + 1)) +
          "], bead_mass_kg: 1, rest_gap_m: [8, 12], spring: {stiffness_N_per_m: 1}, "
          "stroke: {amplitude_N: 1, period_steps: 100, phase_lag_steps: 25, cycles: 2}}",
      "test", {});
  Problems problems(document);
  Case the_case;
  {
    Keys keys(&document.root(), "", problems);
    declare(keys, the_case.swimmers.emplace_back(), 1.0, true);
  }
  problems.throw_if_any();
  return the_case;
}

TEST(Assembly, PutsThePapersSwimmerWhereItStands) {
  const Assembly assembly = assemble(with_swimmer("[0, 0, 1]", "parallel, perpendicular"));
  ASSERT_EQ(assembly.bodies.size(), 3U);
  EXPECT_EQ(assembly.bodies[0].name, "s.B2");
  EXPECT_EQ(assembly.bodies[1].name, "s.B1");
  EXPECT_EQ(assembly.bodies[2].name, "s.B3");
  EXPECT_EQ(assembly.bodies[0].position_m, Eigen::Vector3d(50, 50, 80));
  EXPECT_EQ(assembly.bodies[2].position_m, Eigen::Vector3d(50, 50, 120));
  EXPECT_TRUE(body_axis(assembly.bodies[0]).isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE(body_axis(assembly.bodies[2]).isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_EQ(assembly.springs[0].rest_length_m, 20);
  EXPECT_EQ(assembly.springs[1].rest_length_m, 20);
  EXPECT_EQ(assembly.springs[1].body_A, 1);
  EXPECT_EQ(assembly.springs[1].body_B, 2);
}

TEST(Assembly, TurnsAWholeSwimmerToAnyAxis) {
  for (const std::string axis : {"[1, 0, 0]", "[0, 0, -1]", "[1, 2, 3]"}) {
    const Case the_case = with_swimmer(axis, "parallel, perpendicular");
    const Assembly assembly = assemble(the_case);
    const Eigen::Vector3d direction = z_axis(the_case.swimmers[0].orientation_wxyz);
    EXPECT_TRUE((assembly.bodies[2].position_m - assembly.bodies[0].position_m).isApprox(40 * direction));
    EXPECT_NEAR(body_axis(assembly.bodies[2]).dot(direction), 0.0, 1e-12) << axis;
    EXPECT_NEAR(body_axis(assembly.bodies[0]).dot(direction), 1.0, 1e-12) << axis;
    EXPECT_NEAR(assembly.bodies[2].orientation_wxyz.norm(), 1.0, 1e-12) << axis;
  }
}

}  // namespace
}  // namespace copepod::coupler
