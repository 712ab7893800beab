#include "geometry/smooth_surface.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace copepod {

Eigen::Vector3d SmoothSurface::support_m(const Eigen::Vector3d& n) const {
  const double height_m = std::sqrt(n.dot(squares_m2 * n));
  const Eigen::Vector3d round_m = centre_m + radius_m * n;
  return height_m > 0.0 ? Eigen::Vector3d(round_m + squares_m2 * n / height_m) : round_m;
}

Eigen::Matrix3d SmoothSurface::radii_m(const Eigen::Vector3d& n) const {
  const Eigen::Matrix3d round_m = radius_m * (Eigen::Matrix3d::Identity() - n * n.transpose());
  const Eigen::Vector3d Sn = squares_m2 * n;
  const double height_m = std::sqrt(n.dot(Sn));
  if (!(height_m > 0.0)) return round_m;
  return round_m + (squares_m2 - Sn * Sn.transpose() / (height_m * height_m)) / height_m;
}

Separation separation(const SmoothSurface& first, const SmoothSurface& second, double far_m, double near_m) {
  constexpr int most_steps = 100;
  const Eigen::Vector3d apart_m = first.centre_m - second.centre_m;
  const double tolerance_m = 1e-12 * apart_m.norm();
  const auto points_m = [&](const Eigen::Vector3d& n) {
    return Eigen::Vector3d(first.support_m(-n) - second.support_m(n));
  };
  Separation found{apart_m.normalized()};
  Eigen::Vector3d d = points_m(found.normal);
  found.gap_m = found.normal.dot(d);
  for (int step = 0; step < most_steps && found.gap_m < far_m; ++step) {
    const Eigen::Vector3d& n = found.normal;
    const Eigen::Vector3d across = d - found.gap_m * n;
    if (across.norm() <= tolerance_m || d.norm() < near_m) break;  // no gap is wider than any two points are apart
    Eigen::Matrix3d slope = first.radii_m(n) + second.radii_m(n);
    slope.diagonal().array() += std::max(found.gap_m, 0.0);
    slope += apart_m.norm() * n * n.transpose();  // regular; `across` has no such part
    Eigen::Vector3d change = slope.ldlt().solve(across);
    Separation next;
    do {  // shorter where the largest gap is passed
      next.normal = (n + change).normalized();
      d = points_m(next.normal);
      next.gap_m = next.normal.dot(d);
      change *= 0.5;
    } while (next.gap_m < found.gap_m - tolerance_m && change.norm() > 1e-12);
    found = next;
  }
  return found;
}

}  // namespace copepod
