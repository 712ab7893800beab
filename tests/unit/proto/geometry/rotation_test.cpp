#include "geometry/rotation.hpp"

#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace copepod {
namespace {

const Eigen::Vector4d tilted = Eigen::Vector4d(0.3, -0.5, 0.7, 0.4).normalized();

Eigen::Quaterniond as_eigen(const Eigen::Vector4d& q) { return {q[0], q[1], q[2], q[3]}; }

TEST(Rotation, MatrixIsThatOfAnIndependentLibrary) {
  EXPECT_TRUE(rotation_matrix(tilted).isApprox(as_eigen(tilted).toRotationMatrix(), 1e-15));
}

TEST(Rotation, ZAxisIsTheThirdColumn) { EXPECT_TRUE(z_axis(tilted).isApprox(rotation_matrix(tilted).col(2), 1e-15)); }

TEST(Rotation, TurnsAboutAnAxisOfTheWorld) {
  const Eigen::Vector3d angle(0.4, -1.1, 0.2);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle.norm(), angle.normalized()).toRotationMatrix();
  EXPECT_TRUE(rotation_matrix(rotated(angle, tilted)).isApprox(turn * rotation_matrix(tilted), 1e-14));
}

TEST(Rotation, TurnsByVerySmallAnglesWithoutLosingThem) {
  const Eigen::Vector3d angle(1e-9, 2e-9, -3e-9);
  const Eigen::Vector4d change = (rotated(angle, tilted) - tilted) * 1e9;
  EXPECT_TRUE(change.isApprox(orientation_rate(angle * 1e9, tilted), 1e-6));
  EXPECT_EQ(rotated(Eigen::Vector3d::Zero(), tilted), tilted);
}

TEST(Rotation, OrientationRateIsTheDerivativeOfTurning) {
  const Eigen::Vector3d w(3.0, -1.0, 2.0);
  const double h = 1e-5;
  const Eigen::Vector4d difference = (rotated(h * w, tilted) - rotated(-h * w, tilted)) / (2.0 * h);
  EXPECT_TRUE(difference.isApprox(orientation_rate(w, tilted), 1e-9));
}

}  // namespace
}  // namespace copepod
