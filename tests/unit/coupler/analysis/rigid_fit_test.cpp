#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "analysis/cycle_observer.hpp"

namespace copepod::coupler {
namespace {

constexpr double pi = std::numbers::pi;

Eigen::Matrix3d turn(double angle_rad, const Eigen::Vector3d& about) {
  return Eigen::AngleAxisd(angle_rad, about.normalized()).toRotationMatrix();
}

Eigen::Matrix3Xd moved(const Eigen::Matrix3Xd& points, const Eigen::Matrix3d& rotation,
                       const Eigen::Vector3d& translation) {
  const Eigen::Vector3d centroid = points.rowwise().mean();
  return (rotation * (points.colwise() - centroid)).colwise() + (centroid + translation);
}

Eigen::Matrix3Xd triangle() {
  Eigen::Matrix3Xd points(3, 3);
  points << 16, -8, -9, 0, 14, -13, 0, 0, 0;
  return (points * 1e-6).colwise() + Eigen::Vector3d(50e-6, 40e-6, 100e-6);
}

Eigen::Matrix3Xd row() {
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 3);
  points.row(2) << -16e-6, 0, 20e-6;
  return points;
}

void expect_fit(const Eigen::Matrix3Xd& points, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  const RigidMotion fit = fit_rigid_motion(points, moved(points, rotation, translation));
  EXPECT_LT((fit.rotation - rotation).norm(), 1e-10);
  EXPECT_LT((fit.translation_m - translation).norm(), 1e-18);
}

TEST(RigidFit, FindsTheRotationAndTranslationOfARigidBody) {
  const Eigen::Vector3d translation(1e-6, -2e-7, 3e-9);
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.0})
    for (const Eigen::Vector3d& about : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(1, 0, 0)})
      expect_fit(triangle(), turn(angle, about), translation);
  Eigen::Matrix3Xd tetrahedron(3, 4);
  tetrahedron << triangle(), Eigen::Vector3d(51e-6, 41e-6, 130e-6);
  expect_fit(tetrahedron, turn(2.0, {-1, 1, 5}), translation);
}

TEST(RigidFit, FindsNoMotionInADeformationWithoutOne) {
  // Every bead moves towards the centroid, or the triangle becomes its mirror image in its own plane's normal:
  // the shape changes, and nothing moves or turns.
  const Eigen::Matrix3Xd points = triangle();
  const Eigen::Vector3d centroid = points.rowwise().mean();
  for (const double scale : {0.8, 1.3}) {
    const RigidMotion fit = fit_rigid_motion(points, (scale * (points.colwise() - centroid)).colwise() + centroid);
    EXPECT_LT((fit.rotation - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT(fit.translation_m.norm(), 1e-20);
  }
  // A strain without rotation is a symmetric matrix.
  Eigen::Matrix3d strain;
  strain << 1.2, 0.1, 0, 0.1, 0.9, 0, 0, 0, 1;
  Eigen::Matrix3Xd square(3, 4);
  square << 1, -1, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0;
  EXPECT_LT((fit_rigid_motion(square, strain * square).rotation - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(RigidFit, StaysARotationWhereAReflectionWouldFitBetter) {
  Eigen::Matrix3Xd tetrahedron(3, 4);
  tetrahedron << Eigen::Vector3d(3, 0, 0), Eigen::Vector3d(0, 2, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, 0);
  const Eigen::Matrix3Xd mirrored = Eigen::Vector3d(1, 1, -1).asDiagonal() * tetrahedron;
  const Eigen::Matrix3d rotation = fit_rigid_motion(tetrahedron, mirrored).rotation;
  EXPECT_NEAR(rotation.determinant(), 1.0, 1e-12);
  EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(RigidFit, TurnsBeadsInARowByTheShortestRotation) {
  for (const double angle : {1e-8, 0.3, 3.0}) {
    const Eigen::Matrix3d bend = turn(angle, {1, 1, 0});  // about an axis across the row
    const Eigen::Matrix3d roll = turn(0.7, {0, 0, 1});    // about the row itself: cannot be seen
    const RigidMotion fit = fit_rigid_motion(row(), moved(row(), bend * roll, {0, 0, 1e-6}));
    EXPECT_LT((fit.rotation - bend).norm(), 1e-12) << angle;
    EXPECT_NEAR(rotation_vector(fit.rotation).z(), 0.0, 1e-12);
  }
  const Eigen::Matrix3d back = fit_rigid_motion(row(), -row()).rotation;
  EXPECT_NEAR(rotation_vector(back).norm(), pi, 1e-12);
}

TEST(RigidFit, TakesARowThatTremblesForARow) {
  Eigen::Matrix3Xd before = row(), after = row();
  before(0, 1) += 1e-12;
  after(1, 1) += 1e-12;  // a quarter turn about the row, were it not noise
  EXPECT_LT(rotation_vector(fit_rigid_motion(before, after).rotation).norm(), 1e-5);
}

TEST(RigidFit, TakesBeadsForARowThatLieInOneBeforeOrAfter) {
  // Bent to different sides, by little once and much once: a quarter turn about the row that nothing made.
  Eigen::Matrix3Xd straight = row(), bent = row();
  straight(0, 1) += 1e-9;
  bent(1, 1) += 5e-6;
  const Eigen::Matrix3Xd turned = moved(bent, turn(0.08, {1, 1, 0}), {0, 0, 0});
  EXPECT_NEAR(rotation_vector(fit_rigid_motion(straight, turned).rotation).norm(), 0.08, 0.01);
  EXPECT_NEAR(rotation_vector(fit_rigid_motion(turned, straight).rotation).norm(), 0.08, 0.01);
}

TEST(RigidFit, MovesASinglePointWithoutTurningIt) {
  const Eigen::Matrix3Xd point = Eigen::Vector3d(1, 2, 3);
  const RigidMotion fit = fit_rigid_motion(point, Eigen::Matrix3Xd(Eigen::Vector3d(1, 2, 4)));
  EXPECT_EQ(fit.translation_m, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(fit.rotation, Eigen::Matrix3d::Identity());
}

TEST(RotationVector, HasAxisAndAngle) {
  EXPECT_LT((rotation_vector(turn(0.4, {1, 2, 2})) - 0.4 * Eigen::Vector3d(1, 2, 2) / 3).norm(), 1e-14);
  EXPECT_LT((rotation_vector(turn(1e-9, {0, 1, 0})) - Eigen::Vector3d(0, 1e-9, 0)).norm(), 1e-24);
  EXPECT_EQ(rotation_vector(Eigen::Matrix3d::Identity()), Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace copepod::coupler
