#include "geometry/near_surfaces.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

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

NearSurfaces::NearSurfaces(const FluidSetup& setup, double reach_m)
    : setup_(setup),
      reach_m_(reach_m),
      length_m_(setup.length_m()),
      near_pairs_(setup.bodies, reach_m, setup.periodic_length_m()),
      own_(setup.bodies.size()),
      surfaces_(setup.bodies.size()) {
  std::ranges::sort(setup_.jointed);
  for (const double length_m : near_pairs_.images().length_m)
    if (length_m > 0.0) shortest_period_m_ = std::min(shortest_period_m_, length_m);
  for (std::size_t face = 0; face < 6; ++face)
    mirror_[face] =
        setup.boundaries[face].kind == BoundaryKind::free_slip || (face % 2 == 1 && setup.symmetry_planes[face / 2]);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (setup.symmetry_planes[axis]) length_m_[axis] *= 0.5;
}

NearSurface NearSurfaces::placed(int body, const Kinematics& kinematics) const {
  const Shape& shape = setup_.bodies[body];
  NearSurface surface{.other = body, .radius_m = shape.radius_m};
  surface.core = core_of(shape, body, kinematics.position_m, kinematics.orientation_wxyz);
  if (shape.kind == ShapeKind::ellipsoid) {
    const Eigen::Matrix3d R_WB = rotation_matrix(kinematics.orientation_wxyz.col(body));
    surface.squares_m2 = R_WB * shape.extents_m.cwiseAbs2().asDiagonal() * R_WB.transpose();
    surface.inverse_per_m2 = surface.squares_m2.inverse();
    surface.radius_m = 0.0;
    // Between the normal and the way to the centre, by Kantorovich's inequality: cos ≥ 2ab/(a² + b²)
    const double aspect = shape.extents_m.maxCoeff() / shape.extents_m.minCoeff();
    surface.stretch = 0.5 * (aspect + 1.0 / aspect);
  }
  return surface;
}

void NearSurfaces::find(const Kinematics& kinematics) {
  for (std::size_t body = 0; body < surfaces_.size(); ++body) {
    surfaces_[body].clear();
    own_[body] = placed(static_cast<int>(body), kinematics);
  }
  const auto shape = [this](int body) -> const Shape& { return setup_.bodies[body]; };
  for (const auto& [A, B] : near_pairs_.at(kinematics.position_m)) {
    if (!have_films(shape(A), shape(B))) continue;
    add_images(A, B);
    add_images(B, A);
  }
  for (int body = 0; body < static_cast<int>(surfaces_.size()); ++body) {
    if (!have_films(shape(body), shape(body))) continue;
    add_images(body, body);
    auto& surfaces = surfaces_[body];
    std::ranges::stable_sort(surfaces, {}, &NearSurface::other);
    add_walls(body);
  }
}

/// The other body, its images through periodic faces and, where both are near mirrors, those in them. A mirror image is
/// further away than the body itself, so that its own are all that a body may meet beside those of its partners.
void NearSurfaces::add_images(int body, int other) {
  NearSurface own = own_[body];
  const Eigen::Vector3d centre_m = own.core.centre_W_m;
  own.core.centre_W_m.setZero();
  const NearSurface& original = own_[other];
  const double reach_m = bounding_radius_m(setup_.bodies[body]) + bounding_radius_m(setup_.bodies[other]) + reach_m_;
  const bool jointed = std::ranges::binary_search(setup_.jointed, BodyPair(std::minmax({body, other})));
  const unsigned mirrorings = std::ranges::count(mirror_, true) > 0 ? 8 : 1;
  for (unsigned axes = other == body && reach_m < shortest_period_m_ ? 1 : 0; axes < mirrorings; ++axes) {
    NearSurface surface = original;
    bool exists = true;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (((axes >> axis) & 1U) == 0) continue;
      const bool high = centre_m[axis] > 0.5 * length_m_[axis];
      const double plane_m = high ? length_m_[axis] : 0.0;
      const bool cut = std::abs(original.core.centre_W_m[axis] - plane_m) < 1e-6 * setup_.cell_size_m;  // its own image
      exists = exists && mirror_[2 * axis + (high ? 1 : 0)] && !cut;
      surface.mirrored[axis] = true;
      surface.core.centre_W_m[axis] = 2.0 * plane_m - original.core.centre_W_m[axis];
      surface.core.half_W_m[axis] *= -1.0;
      surface.squares_m2.row(axis) *= -1.0;
      surface.squares_m2.col(axis) *= -1.0;
      surface.inverse_per_m2.row(axis) *= -1.0;
      surface.inverse_per_m2.col(axis) *= -1.0;
    }
    if (!exists) continue;
    const Eigen::Vector3d apart_m = surface.core.centre_W_m - centre_m;
    near_pairs_.images().for_each(apart_m, reach_m, [&](const Eigen::Vector3d& place_m, const auto& number) {
      if (axes == 0 && other == body && number.isZero(0.0)) return;
      surface.core.centre_W_m = place_m;
      const double gap_m = own.is_ellipsoid() || surface.is_ellipsoid()
                               ? separation(own.smooth(), surface.smooth(), reach_m_, jointed ? 0.0 : reach_m_).gap_m
                               : segment_distance_m(own.core, surface.core) - own.radius_m - surface.radius_m;
      const bool one_surface = jointed && axes == 0 && gap_m < 1e-3 * setup_.cell_size_m;
      if (gap_m >= reach_m_ || one_surface) return;
      surface.normal = -place_m.normalized();
      surface.distance_of_centre_m = place_m.norm() - surface.radius_m -
                                     std::abs(surface.normal.dot(surface.core.half_W_m)) -
                                     std::sqrt(surface.normal.dot(surface.squares_m2 * surface.normal));
      surfaces_[body].push_back(surface);
    });
  }
}

void NearSurfaces::add_walls(int body) {
  const NearSurface& own = own_[body];
  for (int face = 0; face < 6; ++face) {
    if (!setup_.boundaries[face].is_wall(face) || mirror_[face]) continue;
    const Eigen::Index axis = face / 2;
    const double sign = face % 2 == 0 ? 1.0 : -1.0;
    const double distance_m = face % 2 == 0 ? own.core.centre_W_m[axis] : length_m_[axis] - own.core.centre_W_m[axis];
    const double extent_m = own.radius_m + std::abs(own.core.half_W_m[axis]) + std::sqrt(own.squares_m2(axis, axis));
    if (distance_m - extent_m >= reach_m_) continue;
    NearSurface wall{.face = face};
    wall.normal[axis] = sign;
    wall.distance_of_centre_m = distance_m;
    surfaces_[body].push_back(wall);
  }
}

}  // namespace copepod
