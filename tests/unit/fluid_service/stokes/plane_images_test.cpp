
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "stokes/stokes_flow.hpp"

namespace copepod::fluid {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double viscosity_Pa_s = 0.7;

ImageMobility of_points(const Vector3d& x, const Vector3d& y) { return image_mobility(x, 0.0, y, 0.0, viscosity_Pa_s); }

/// Mean of a tensor over the surface of a sphere: 60 rings of equal area, 24 points each; error about 1e-4.
Matrix3d mean_over_sphere(const Vector3d& centre, double radius, const std::function<Matrix3d(Vector3d)>& tensor) {
  constexpr int rings = 60;
  constexpr int points = 24;
  Matrix3d sum = Matrix3d::Zero();
  for (int ring = 0; ring < rings; ++ring) {
    const double z = -1.0 + (ring + 0.5) * 2.0 / rings;
    const double across = std::sqrt(1.0 - z * z);
    for (int point = 0; point < points; ++point) {
      const double phi = 2.0 * pi * point / points;
      sum += tensor(centre + radius * Vector3d(across * std::cos(phi), across * std::sin(phi), z));
    }
  }
  return sum / (rings * points);
}

/// 1/2 curl of a tensor field, acting on the rows' index.
Matrix3d half_curl(const Vector3d& place, const std::function<Matrix3d(Vector3d)>& tensor) {
  constexpr double step = 1e-5;
  Matrix3d curl = Matrix3d::Zero();
  for (int m = 0; m < 3; ++m) {
    const Vector3d shift = step * Vector3d::Unit(m);
    const Matrix3d slope = (tensor(place + shift) - tensor(place - shift)) / (2.0 * step);
    for (int column = 0; column < 3; ++column) curl.col(column) += 0.5 * Vector3d::Unit(m).cross(slope.col(column));
  }
  return curl;
}

const Vector3d x(0.3, -0.2, 1.9);
const Vector3d y(1.4, 0.9, 1.3);

// The condition that the images are made for.
TEST(PlaneImages, BringTheFluidAtThePlaneToRest) {
  const Vector3d on_plane(0.4, -1.1, 0.0);
  const Vector3d r = on_plane - y;
  const Matrix3d stokeslet =
      (Matrix3d::Identity() / r.norm() + r * r.transpose() / std::pow(r.norm(), 3)) / (8.0 * pi * viscosity_Pa_s);
  EXPECT_LT((of_points(on_plane, y).tt + stokeslet).norm(), 1e-16);
}

// Faxén 1922 and Perkins & Jones 1992, the polynomial parts.
TEST(PlaneImages, HaveTheKnownCorrectionsOfOneSphere) {
  const double a = 0.8;
  const double h = 1.7;
  const double s = a / h;
  const ImageMobility self = image_mobility({1, 2, h}, a, {1, 2, h}, a, viscosity_Pa_s);
  const double free_tt = 1.0 / (6.0 * pi * viscosity_Pa_s * a);
  const double free_rr = 1.0 / (8.0 * pi * viscosity_Pa_s * a * a * a);
  const double parallel = -9.0 / 16.0 * s + std::pow(s, 3) / 8.0 - std::pow(s, 5) / 16.0;
  const double perpendicular = -9.0 / 8.0 * s + std::pow(s, 3) / 2.0 - std::pow(s, 5) / 8.0;
  EXPECT_LT((self.tt / free_tt - Matrix3d(Vector3d(parallel, parallel, perpendicular).asDiagonal())).norm(), 1e-15);
  const double about_plane_axis = -5.0 / 16.0 * std::pow(s, 3);
  const double about_normal = -std::pow(s, 3) / 8.0;
  EXPECT_LT(
      (self.rr / free_rr - Matrix3d(Vector3d(about_plane_axis, about_plane_axis, about_normal).asDiagonal())).norm(),
      1e-15);
  // A force along x turns the sphere as if it rolled off: 3/32 s⁴ of F/(6πηa²).
  EXPECT_NEAR(self.rt(1, 0) / (free_tt / a), 3.0 / 32.0 * std::pow(s, 4), 1e-15);
}

TEST(PlaneImages, AreSurfaceAveragesOfTheGreensFunction) {
  const double a = 0.9;
  const double b = 0.6;
  const Matrix3d mean = mean_over_sphere(x, a, [&](const Vector3d& place) {
    return mean_over_sphere(y, b, [&](const Vector3d& source) { return of_points(place, source).tt; });
  });
  const ImageMobility images = image_mobility(x, a, y, b, viscosity_Pa_s);
  EXPECT_LT((images.tt - mean).norm() / mean.norm(), 3e-4);
  EXPECT_GT((images.tt - of_points(x, y).tt).norm() / mean.norm(), 1e-2);  // the radii do matter
  const Matrix3d mean_rt = mean_over_sphere(y, b, [&](const Vector3d& source) { return of_points(x, source).rt; });
  EXPECT_LT((images.rt - mean_rt).norm() / mean_rt.norm(), 3e-4);
  EXPECT_GT((images.rt - of_points(x, y).rt).norm() / mean_rt.norm(), 1e-2);
}

TEST(PlaneImages, TurnSpheresByHalfTheVorticity) {
  const Matrix3d by_force = half_curl(x, [](const Vector3d& place) { return of_points(place, y).tt; });
  EXPECT_LT((of_points(x, y).rt - by_force).norm() / by_force.norm(), 1e-9);
  // The flow of a torque is that of a force, differentiated by the place of the source: reciprocity.
  const auto by_torque = [](const Vector3d& place) -> Matrix3d { return of_points(y, place).rt.transpose(); };
  const Matrix3d turning = half_curl(x, by_torque);
  EXPECT_LT((of_points(x, y).rr - turning).norm() / turning.norm(), 1e-9);
}

/// Spheres of various sizes, some nearly in touch with each other and with the plane.
struct Crowd {
  Eigen::Matrix3Xd position_m{3, 8};
  std::vector<double> radius_m;

  Crowd() {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> size(0.2, 1.0);
    for (int i = 0; i < 8; ++i) radius_m.push_back(size(random));
    Vector3d corner(0, 0, 0);
    for (int i = 0; i < 8; ++i) {
      const double r = radius_m[static_cast<std::size_t>(i)];
      const double x_m = i == 0 ? 0.0 : corner[0] + r + 1e-3;
      position_m.col(i) << x_m, 0.0, r * (1.001 + 0.5 * (i % 3));
      corner[0] = x_m + r;
    }
  }
};

NoSlipPlane plane_of(int face) {
  FluidSetup setup;
  setup.no_slip_plane = face;
  setup.domain_cells = {4, 5, 6};
  setup.cell_size_m = 0.5;
  return no_slip_plane_of(setup);
}

constexpr int z_low = 4;

TEST(PlaneImages, KeepTheMobilitySymmetricAndPositive) {
  const Crowd crowd;
  Eigen::MatrixXd mobility = grand_mobility(crowd.position_m, crowd.radius_m, viscosity_Pa_s);
  add_plane_images(mobility, plane_of(z_low), crowd.position_m, crowd.radius_m, viscosity_Pa_s);
  EXPECT_LT((mobility - mobility.transpose()).norm() / mobility.norm(), 1e-15);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(mobility);
  EXPECT_GT(spectrum.eigenvalues().minCoeff(), 0.0);
}

TEST(PlaneImages, AreTheSameForEveryFaceOfTheDomain) {
  const std::vector<double> radius_m{0.3, 0.2};
  Eigen::Matrix3Xd above_plane(3, 2);  // in the frame of the plane
  above_plane << 0.1, 0.8, -0.2, 0.3, 0.5, 0.9;
  Eigen::MatrixXd expected = grand_mobility(above_plane, radius_m, viscosity_Pa_s);
  add_plane_images(expected, plane_of(z_low), above_plane, radius_m, viscosity_Pa_s);
  for (int face = 0; face < 6; ++face) {
    const NoSlipPlane plane = plane_of(face);
    EXPECT_EQ(plane.rotation.determinant(), 1.0) << face;
    EXPECT_EQ(plane.origin_m[face / 2], face % 2 == 0 ? 0.0 : 0.5 * (4 + face / 2)) << face;
    const Eigen::Matrix3Xd position_m = (plane.rotation.transpose() * above_plane).colwise() + plane.origin_m;
    Eigen::MatrixXd mobility = grand_mobility(position_m, radius_m, viscosity_Pa_s);
    add_plane_images(mobility, plane, position_m, radius_m, viscosity_Pa_s);
    Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(12, 12);
    for (int block = 0; block < 4; ++block) turned.block<3, 3>(3 * block, 3 * block) = plane.rotation;
    EXPECT_LT((turned * mobility * turned.transpose() - expected).norm() / expected.norm(), 1e-14) << face;
  }
}

TEST(PlaneImages, RefuseASphereThatReachesThePlane) {
  Eigen::Matrix3Xd position_m(3, 1);
  position_m << 0, 0, 0.29;
  const std::vector<double> radius_m{0.3};
  Eigen::MatrixXd mobility = grand_mobility(position_m, radius_m, viscosity_Pa_s);
  EXPECT_THROW(add_plane_images(mobility, plane_of(z_low), position_m, radius_m, viscosity_Pa_s), SolverError);
}

/// Exact drag of a sphere moving towards a plane, over 6πηaU [Brenner 1961], with cosh α = h/a.
double brenner_drag(double h_over_a) {
  const double alpha = std::acosh(h_over_a);
  double sum = 0.0;
  for (int n = 1; n < 200; ++n) {
    const double odd = 2.0 * n + 1.0;
    const double numerator = 2.0 * std::sinh(odd * alpha) + odd * std::sinh(2.0 * alpha);
    const double root = 2.0 * std::sinh((n + 0.5) * alpha);
    const double second = odd * std::sinh(alpha);
    const double term =
        n * (n + 1.0) / ((2.0 * n - 1.0) * (2.0 * n + 3.0)) * (numerator / (root * root - second * second) - 1.0);
    sum += term;
    if (std::abs(term) < 1e-14 * sum) break;
  }
  return 4.0 / 3.0 * std::sinh(alpha) * sum;
}

// What the neglect of lubrication costs; the figures are in docs/theory_fluid.md.
TEST(PlaneImages, ApproachTheExactDragAwayFromThePlane) {
  const auto error_percent = [](double h) {
    const ImageMobility self = image_mobility({0, 0, h}, 1.0, {0, 0, h}, 1.0, 1.0 / (6.0 * pi));
    return 100.0 * ((1.0 + self.tt(2, 2)) * brenner_drag(h) - 1.0);
  };
  EXPECT_NEAR(brenner_drag(1.5430806), 3.0361, 1e-4);  // Brenner's table, α = 1
  EXPECT_NEAR(error_percent(10.0), 0.01, 0.01);
  EXPECT_NEAR(error_percent(4.0), 0.29, 0.03);
  EXPECT_NEAR(error_percent(2.0), 5.8, 0.5);
  EXPECT_NEAR(error_percent(1.5), 22.0, 2.0);
}

}  // namespace
}  // namespace copepod::fluid
