#include "contract/shape.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace copepod {
namespace {

struct ByDiscs {
  double volume_m3 = 0.0;
  double along_kg_m2 = 0.0;
  double across_kg_m2 = 0.0;
};

/// Volume and inertia of a solid of revolution about z, summed over thin discs: a disc of
/// radius s at height z has inertia s²/2 about z and s²/4 + z² about a transverse axis, per unit of its mass.
ByDiscs by_discs(const Shape& shape, double mass_kg) {
  const double half = core_half_length_m(shape);
  const double end = half + shape.radius_m;
  constexpr int discs = 400000;
  double volume = 0.0;
  double along = 0.0;
  double across = 0.0;
  for (int i = 0; i < discs; ++i) {
    const double z = -end + (i + 0.5) * 2.0 * end / discs;
    const double beyond_core = std::max(0.0, std::abs(z) - half);
    const double s2 = shape.radius_m * shape.radius_m - beyond_core * beyond_core;
    const double disc = std::numbers::pi * s2 * 2.0 * end / discs;
    volume += disc;
    along += disc * s2 / 2.0;
    across += disc * (s2 / 4.0 + z * z);
  }
  const double density = mass_kg / volume;
  return {volume, density * along, density * across};
}

TEST(Shape, VolumeAndInertiaOfACapsuleAgreeWithTheIntegralOverThinDiscs) {
  const Shape capsule{ShapeKind::capsule, 4e-6, 8e-6};
  const Eigen::Matrix3d exact = inertia_tensor_kg_m2(capsule, 5.44e-13);
  const ByDiscs integral = by_discs(capsule, 5.44e-13);
  EXPECT_NEAR(volume_m3(capsule) / integral.volume_m3, 1.0, 1e-9);
  EXPECT_NEAR(exact(2, 2) / integral.along_kg_m2, 1.0, 1e-9);
  EXPECT_NEAR(exact(0, 0) / integral.across_kg_m2, 1.0, 1e-9);
  EXPECT_GT(exact(0, 0), 1.5 * exact(2, 2));
}

TEST(Shape, VolumeAndInertiaOfASphereAreTheTextbookOnes) {
  const Shape sphere{ShapeKind::sphere, 2.0, 0.0};
  EXPECT_DOUBLE_EQ(volume_m3(sphere), 4.0 / 3.0 * std::numbers::pi * 8.0);
  EXPECT_DOUBLE_EQ(inertia_tensor_kg_m2(sphere, 5.0)(2, 2), 0.4 * 5.0 * 4.0);
  EXPECT_DOUBLE_EQ(inertia_tensor_kg_m2(sphere, 5.0)(0, 0), 0.4 * 5.0 * 4.0);
}

TEST(Shape, ACapsuleWithoutCylinderIsASphere) {
  const Shape sphere{ShapeKind::sphere, 3.0, 0.0};
  const Shape capsule{ShapeKind::capsule, 3.0, 0.0};
  EXPECT_DOUBLE_EQ(volume_m3(sphere), volume_m3(capsule));
  EXPECT_DOUBLE_EQ(inertia_tensor_kg_m2(sphere, 2.0)(0, 0), inertia_tensor_kg_m2(capsule, 2.0)(0, 0));
}

TEST(Shape, InertiaOfALongCapsuleApproachesThatOfARod) {
  EXPECT_NEAR(inertia_tensor_kg_m2({ShapeKind::capsule, 1e-4, 2.0}, 3.0)(0, 0), 3.0 * 4.0 / 12.0, 1e-3);
}

TEST(Shape, BoundingRadiusReachesTheEndOfTheShape) {
  EXPECT_DOUBLE_EQ(bounding_radius_m({ShapeKind::capsule, 4.0, 8.0}), 8.0);
  EXPECT_DOUBLE_EQ(bounding_radius_m({ShapeKind::sphere, 4.0, 8.0}), 4.0) << "a sphere has no cylinder";
}

}  // namespace
}  // namespace copepod
