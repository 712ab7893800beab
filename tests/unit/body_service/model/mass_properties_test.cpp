#include "model/mass_properties.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace copepod::body {
namespace {

/// Volume and inertia of a solid of revolution about z, summed over thin discs: a disc of
/// radius s at height z has inertia s²/2 about z and s²/4 + z² about a transverse axis, per unit of its mass.
MassProperties by_discs(const Shape& shape, double mass_kg) {
  const double half = core_half_length_m(shape);
  const double end = half + shape.radius_m;
  constexpr int discs = 400000;
  double volume = 0.0;
  double axial = 0.0;
  double transverse = 0.0;
  for (int i = 0; i < discs; ++i) {
    const double z = -end + (i + 0.5) * 2.0 * end / discs;
    const double beyond_core = std::max(0.0, std::abs(z) - half);
    const double s2 = shape.radius_m * shape.radius_m - beyond_core * beyond_core;
    const double disc = std::numbers::pi * s2 * 2.0 * end / discs;
    volume += disc;
    axial += disc * s2 / 2.0;
    transverse += disc * (s2 / 4.0 + z * z);
  }
  const double density = mass_kg / volume;
  return {volume, (density * Eigen::Vector3d(transverse, transverse, axial)).asDiagonal()};
}

TEST(MassProperties, OfACapsuleAgreeWithTheIntegralOverThinDiscs) {
  const Shape capsule{ShapeKind::capsule, 4e-6, 8e-6};
  const MassProperties exact = mass_properties(capsule, 5.44e-13);
  const MassProperties integral = by_discs(capsule, 5.44e-13);
  EXPECT_NEAR(exact.volume_m3 / integral.volume_m3, 1.0, 1e-9);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(exact.inertia_kg_m2(i, i) / integral.inertia_kg_m2(i, i), 1.0, 1e-9);
  EXPECT_GT(exact.inertia_kg_m2(0, 0), 1.5 * exact.inertia_kg_m2(2, 2));
}

TEST(MassProperties, OfASphereAreTheTextbookOnes) {
  const MassProperties sphere = mass_properties({ShapeKind::sphere, 2.0, 0.0}, 5.0);
  EXPECT_DOUBLE_EQ(sphere.volume_m3, 4.0 / 3.0 * std::numbers::pi * 8.0);
  EXPECT_TRUE(sphere.inertia_kg_m2.isApprox(0.4 * 5.0 * 4.0 * Eigen::Matrix3d::Identity(), 1e-15));
}

TEST(MassProperties, OfACapsuleWithoutCylinderAreThoseOfASphere) {
  const MassProperties sphere = mass_properties({ShapeKind::sphere, 3.0, 0.0}, 2.0);
  const MassProperties capsule = mass_properties({ShapeKind::capsule, 3.0, 0.0}, 2.0);
  EXPECT_DOUBLE_EQ(sphere.volume_m3, capsule.volume_m3);
  EXPECT_TRUE(sphere.inertia_kg_m2.isApprox(capsule.inertia_kg_m2, 1e-15));
}

TEST(MassProperties, OfALongCapsuleApproachThoseOfARod) {
  const MassProperties rod = mass_properties({ShapeKind::capsule, 1e-4, 2.0}, 3.0);
  EXPECT_NEAR(rod.inertia_kg_m2(0, 0), 3.0 * 4.0 / 12.0, 1e-3);
}

TEST(MassProperties, TellHowFarAShapeReaches) {
  EXPECT_DOUBLE_EQ(bounding_radius_m({ShapeKind::capsule, 4.0, 8.0}), 8.0);
  EXPECT_DOUBLE_EQ(bounding_radius_m({ShapeKind::sphere, 4.0, 8.0}), 4.0) << "a sphere has no cylinder";
}

}  // namespace
}  // namespace copepod::body
