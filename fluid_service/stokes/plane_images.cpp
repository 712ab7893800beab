#include "stokes/plane_images.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace copepod::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Derivatives of the Stokeslet and of its vortex at R, seen from the mirror image of the source.
struct ImageFlow {
  explicit ImageFlow(const Vector3d& separation)
      : R(separation), r2(R.squaredNorm()), r3(r2 * std::sqrt(r2)), r5(r3 * r2), r7(r5 * r2), r9(r7 * r2) {}

  /// 1/R + RR/R³
  [[nodiscard]] Matrix3d S() const { return unit / std::sqrt(r2) + RR / r3; }
  /// ∂_j (R_i/R³)
  [[nodiscard]] Matrix3d P() const { return unit / r3 - 3.0 * RR / r5; }
  [[nodiscard]] Matrix3d P_3() const { return -3.0 * (R[2] * unit + zR + Rz) / r5 + 15.0 * R[2] * RR / r7; }
  [[nodiscard]] Matrix3d P_33() const {
    const double z2 = R[2] * R[2];
    return -3.0 * (unit + 2.0 * zz) / r5 + 15.0 * (z2 * unit + 2.0 * R[2] * (zR + Rz) + RR) / r7 - 105.0 * z2 * RR / r9;
  }
  /// ∂_j S_i3
  [[nodiscard]] Matrix3d Q() const { return (R[2] * unit + Rz - zR) / r3 - 3.0 * R[2] * RR / r5; }
  [[nodiscard]] Matrix3d Q_3() const {
    const double z2 = R[2] * R[2];
    return unit / r3 - 3.0 * (z2 * unit + 2.0 * R[2] * Rz + RR) / r5 + 15.0 * z2 * RR / r7;
  }
  /// ∂_m (e_j × R/R³), half the vorticity of a Stokeslet along j; axes counted from 0
  [[nodiscard]] Vector3d W_m(int j, int m) const {
    const Vector3d e_j = Vector3d::Unit(j);
    return e_j.cross(Vector3d::Unit(m)) / r3 - 3.0 * R[m] * e_j.cross(R) / r5;
  }
  /// ∂_3 ∂_m (e_3 × R/R³)
  [[nodiscard]] Vector3d W3_3m(int m) const {
    const Vector3d z = Vector3d::UnitZ();
    const double along = m == 2 ? 1.0 : 0.0;
    return -3.0 * (R[2] * z.cross(Vector3d::Unit(m)) + along * z.cross(R)) / r5 + 15.0 * R[m] * R[2] * z.cross(R) / r7;
  }

  Vector3d R;
  double r2, r3, r5, r7, r9;
  Matrix3d unit = Matrix3d::Identity();
  Matrix3d RR = R * R.transpose();
  Matrix3d Rz = R * Vector3d::UnitZ().transpose();
  Matrix3d zR = Rz.transpose();
  Matrix3d zz = Vector3d::UnitZ() * Vector3d::UnitZ().transpose();
};

const Vector3d mirror(1.0, 1.0, -1.0);  // the diagonal of Δ

Matrix3d translation(const ImageFlow& flow, double a, double b, double h) {
  const auto delta = mirror.asDiagonal();
  const Matrix3d G = -flow.S() + (2.0 * h * h * flow.P() - 2.0 * h * flow.Q()) * delta;
  const Matrix3d of_x = -2.0 * flow.P() - 4.0 * h * flow.P_3() * delta;
  const Matrix3d of_y = -2.0 * flow.P() + 4.0 * (h * flow.P_3() + flow.P() - flow.Q_3()) * delta;
  const Matrix3d of_both = -8.0 * flow.P_33() * delta;
  return G + a * a / 6.0 * of_x + b * b / 6.0 * of_y + a * a * b * b / 36.0 * of_both;
}

/// −W_j − 2h Δ_jj ∂_j W_3 − 2/3 b² Δ_jj ∂_3 ∂_j W_3, the curl of (1 + b²/6 ∇y²) G/2.
Matrix3d turning_by_force(const ImageFlow& flow, double b, double h) {
  Matrix3d columns;
  for (int j = 0; j < 3; ++j) {
    columns.col(j) = -Vector3d::Unit(j).cross(flow.R) / flow.r3 -
                     mirror[j] * (2.0 * h * flow.W_m(2, j) + 2.0 / 3.0 * b * b * flow.W3_3m(j));
  }
  return columns;
}

/// 1/2 ε_nmj ∂/∂y_m of the above for b = 0; ∂/∂y_m is −Δ_mm ∂_m on functions of R, and ∂/∂h is 1 on h.
Matrix3d turning_by_torque(const ImageFlow& flow) {
  const auto term = [&flow](int m, int j) -> Vector3d {
    const Vector3d through_R = mirror[m] * flow.W_m(j, m);
    return m == 2 ? Vector3d(through_R - 2.0 * mirror[j] * flow.W_m(2, j)) : through_R;
  };
  Matrix3d columns;
  for (int n = 0; n < 3; ++n) {
    const int m = (n + 1) % 3;
    const int j = (n + 2) % 3;
    columns.col(n) = 0.5 * (term(m, j) - term(j, m));
  }
  return columns;
}

}  // namespace

ImageMobility image_mobility(const Vector3d& x_m, double a_m, const Vector3d& y_m, double b_m, double viscosity_Pa_s) {
  const double h = y_m[2];
  const ImageFlow flow({x_m[0] - y_m[0], x_m[1] - y_m[1], x_m[2] + h});
  const double scale = 1.0 / (8.0 * std::numbers::pi * viscosity_Pa_s);
  return {scale * translation(flow, a_m, b_m, h), scale * turning_by_force(flow, b_m, h),
          scale * turning_by_torque(flow)};
}

NoSlipPlane no_slip_plane_of(const FluidSetup& setup) {
  const int axis = setup.no_slip_plane / 2;
  const bool high = setup.no_slip_plane % 2 == 1;
  const Vector3d first = Vector3d::Unit((axis + 1) % 3);
  const Vector3d second = Vector3d::Unit((axis + 2) % 3);
  NoSlipPlane plane;
  // Of the two axes in the plane, the order is what makes the frame right-handed.
  plane.rotation.row(0) = high ? second : first;
  plane.rotation.row(1) = high ? first : second;
  plane.rotation.row(2) = (high ? -1.0 : 1.0) * Vector3d::Unit(axis);
  const double length_m = static_cast<double>(setup.domain_cells[static_cast<std::size_t>(axis)]) * setup.cell_size_m;
  plane.origin_m = (high ? length_m : 0.0) * Vector3d::Unit(axis);
  return plane;
}

}  // namespace copepod::fluid
