#include "config/checks/geometry.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "config/sections/expand.hpp"

namespace copepod::coupler {
namespace {

BodySpecification capsule(const Eigen::Vector3d& position, const Eigen::Vector4d& q, double radius,
                          double length) {
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

TEST(Geometry, KnowsTheVolumeOfACapsule) {
  EXPECT_DOUBLE_EQ(volume_m3({ShapeKind::capsule, 2.0, 3.0}), std::numbers::pi * (4.0 / 3.0 * 8 + 4 * 3));
}

TEST(Geometry, KnowsTheInertiaOfSpheresAndOfLongCapsules) {
  const Inertia sphere = inertia_of({ShapeKind::sphere, 2.0, 0.0}, 5.0);
  EXPECT_DOUBLE_EQ(sphere.along_kg_m2, 0.4 * 5.0 * 4.0);
  EXPECT_DOUBLE_EQ(sphere.across_kg_m2, sphere.along_kg_m2);
  const Inertia rod = inertia_of({ShapeKind::capsule, 1.0, 1000.0}, 5.0);
  EXPECT_NEAR(rod.along_kg_m2, 5.0 / 2.0, 0.01 * rod.along_kg_m2);
  EXPECT_NEAR(rod.across_kg_m2, 5.0 * 1000.0 * 1000.0 / 12.0, 0.01 * rod.across_kg_m2);
}

TEST(Geometry, MeasuresDistancesBetweenCapsules) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  const auto at = [&](const Eigen::Vector3d& p, const Eigen::Vector4d& q) { return capsule(p, q, 1, 4); };
  // Side by side, end to end, crossed, a T, and skew beyond both ends.
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({5, 0, 0}, upright), none), 3.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 0, 9}, upright), none), 3.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 4, 0}, along_x), none), 2.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 0, 5}, along_x), none), 1.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({0, 5, 6}, along_y), none), 5.0 - 2.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({1, 0, 0}, upright), none), -1.0, 1e-12);
  EXPECT_NEAR(surface_distance_m(at({0, 0, 0}, upright), at({15, 0, 0}, upright), {-10, 0, 0}), 3.0, 1e-12);
}

TEST(Geometry, MeasuresDistancesBetweenSpheresAndCapsules) {
  BodySpecification sphere;
  sphere.shape = {ShapeKind::sphere, 1.0, 0.0};
  sphere.position_m = {3, 0, 1};
  EXPECT_NEAR(surface_distance_m(sphere, capsule({0, 0, 0}, upright, 1, 4), Eigen::Vector3d::Zero()), 1.0,
              1e-12);
}

TEST(Assembly, PutsThePapersSwimmerWhereItStands) {
  Case the_case;
  Swimmer swimmer;
  swimmer.name = "s";
  swimmer.center_m = {50, 50, 100};
  swimmer.beads[0] = {{ShapeKind::capsule, 4, 8}, BeadOrientation::parallel};
  swimmer.beads[1] = {{ShapeKind::sphere, 4, 0}, BeadOrientation::parallel};
  swimmer.beads[2] = {{ShapeKind::capsule, 4, 8}, BeadOrientation::perpendicular};
  swimmer.rest_gap_m = {8, 12};
  swimmer.bead_mass_kg = 1;
  swimmer.stroke = {1, 100, 25, 2};
  the_case.swimmers = {swimmer};
  const Assembly assembly = assemble(the_case);
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

TEST(Assembly, TurnsPerpendicularCapsulesAcrossAnyAxis) {
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(1, 2, 3)}) {
    Case the_case;
    Swimmer swimmer;
    swimmer.axis = direction.normalized();
    swimmer.beads[0] = {{ShapeKind::capsule, 4, 8}, BeadOrientation::perpendicular};
    swimmer.beads[1] = {{ShapeKind::capsule, 4, 8}, BeadOrientation::parallel};
    the_case.swimmers = {swimmer};
    const Assembly assembly = assemble(the_case);
    EXPECT_NEAR(body_axis(assembly.bodies[0]).dot(swimmer.axis), 0.0, 1e-12);
    EXPECT_NEAR(std::abs(body_axis(assembly.bodies[1]).dot(swimmer.axis)), 1.0, 1e-12);
    EXPECT_NEAR(assembly.bodies[0].orientation_wxyz.norm(), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace copepod::coupler
