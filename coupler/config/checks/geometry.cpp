#include "config/checks/geometry.hpp"

#include <algorithm>
#include <numbers>

#include <Eigen/Geometry>

namespace copepod::coupler {
namespace {

/// Shortest distance between the segments p ± a/2 and q ± b/2.
/// The closest points minimise |p + s a − q − t b|² over s, t ∈ [−1/2, 1/2]; after one unconstrained solve
/// for s, clamping t and then s again finds the minimum (Ericson, Real-Time Collision Detection, 5.1.9).
double segment_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& q,
                        const Eigen::Vector3d& b) {
  const Eigen::Vector3d r = p - q;
  const double aa = a.squaredNorm();
  const double bb = b.squaredNorm();
  const double ab = a.dot(b);
  const double determinant = aa * bb - ab * ab;
  const auto clamp = [](double x) { return std::clamp(x, -0.5, 0.5); };
  double s = determinant > 1e-12 * aa * bb ? clamp((ab * b.dot(r) - bb * a.dot(r)) / determinant) : 0.0;
  double t = bb > 0.0 ? clamp((b.dot(r) + s * ab) / bb) : 0.0;
  s = aa > 0.0 ? clamp((t * ab - a.dot(r)) / aa) : 0.0;
  t = bb > 0.0 ? clamp((b.dot(r) + s * ab) / bb) : 0.0;
  return (r + s * a - t * b).norm();
}

}  // namespace

Eigen::Vector3d in_world(const BodySpecification& body, const Eigen::Vector3d& vector_B) {
  const Eigen::Vector4d& q = body.orientation_wxyz;
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * vector_B;
}

Eigen::Vector3d body_axis(const BodySpecification& body) {
  const double w = body.orientation_wxyz[0];
  const double x = body.orientation_wxyz[1];
  const double y = body.orientation_wxyz[2];
  const double z = body.orientation_wxyz[3];
  return {2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z};
}

Eigen::Vector3d half_extents_m(const BodySpecification& body) {
  const Eigen::Vector3d axis = body_axis(body);
  return Eigen::Vector3d::Constant(body.shape.radius_m) + 0.5 * body.shape.length_m * axis.cwiseAbs();
}

double volume_m3(const Shape& shape) {
  const double r = shape.radius_m;
  return std::numbers::pi * r * r * (4.0 / 3.0 * r + shape.length_m);
}

Inertia inertia_of(const Shape& shape, double mass_kg) {
  const double r = shape.radius_m;
  const double l = shape.length_m;
  const double cylinder_kg = mass_kg * l / (l + 4.0 / 3.0 * r);
  const double half_spheres_kg = mass_kg - cylinder_kg;
  return {r * r * (cylinder_kg / 2.0 + 0.4 * half_spheres_kg),
          cylinder_kg * (l * l / 12.0 + r * r / 4.0) +
              half_spheres_kg * (0.4 * r * r + 0.375 * l * r + l * l / 4.0)};
}

double surface_distance_m(const BodySpecification& A, const BodySpecification& B,
                          const Eigen::Vector3d& shift_m) {
  const double between_axes = segment_distance(A.position_m, A.shape.length_m * body_axis(A),
                                               B.position_m + shift_m, B.shape.length_m * body_axis(B));
  return between_axes - A.shape.radius_m - B.shape.radius_m;
}

}  // namespace copepod::coupler
