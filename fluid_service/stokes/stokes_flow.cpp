#include "stokes/stokes_flow.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "contract/errors.hpp"
#include "system/process.hpp"

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
  for (int j = 0; j < 3; ++j)
    columns.col(j) = -Vector3d::Unit(j).cross(flow.R) / flow.r3 -
                     mirror[j] * (2.0 * h * flow.W_m(2, j) + 2.0 / 3.0 * b * b * flow.W3_3m(j));
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

using std::numbers::pi;

/// The matrix of v ↦ v × r.
Eigen::Matrix3d cross_with(const Eigen::Vector3d& r) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, r[2], -r[1], -r[2], 0.0, r[0], r[1], -r[0], 0.0;
  return matrix;
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
  const double length_m = static_cast<double>(setup.domain_cells[axis]) * setup.cell_size_m;
  plane.origin_m = (high ? length_m : 0.0) * Vector3d::Unit(axis);
  return plane;
}

Eigen::MatrixXd grand_mobility(const Eigen::Matrix3Xd& position_m, std::span<const double> radius_m,
                               double viscosity_Pa_s) {
  const Eigen::Index n = position_m.cols();
  const double eta = viscosity_Pa_s;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  Eigen::MatrixXd mobility = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double a = radius_m[i];
    mobility.block<3, 3>(3 * i, 3 * i) = unit / (6.0 * pi * eta * a);
    mobility.block<3, 3>(3 * (n + i), 3 * (n + i)) = unit / (8.0 * pi * eta * a * a * a);
    for (Eigen::Index j = 0; j < i; ++j) {
      const double b = radius_m[j];
      const Eigen::Vector3d separation = position_m.col(i) - position_m.col(j);
      const double r = separation.norm();
      if (!(r > a + b))
        throw SolverError("spheres " + std::to_string(j) + " and " + std::to_string(i) +
                          " overlap (Stokes mobility is not defined then). Use weaker forces or larger gaps.");
      const Eigen::Matrix3d along = separation * separation.transpose() / (r * r);
      const double radii = (a * a + b * b) / (r * r);
      const Eigen::Matrix3d translation = ((1.0 + radii / 3.0) * unit + (1.0 - radii) * along) / (8.0 * pi * eta * r);
      const Eigen::Matrix3d rotation = (3.0 * along - unit) / (16.0 * pi * eta * r * r * r);
      const Eigen::Matrix3d mixed = cross_with(separation) / (8.0 * pi * eta * r * r * r);
      mobility.block<3, 3>(3 * i, 3 * j) = translation;
      mobility.block<3, 3>(3 * j, 3 * i) = translation;
      mobility.block<3, 3>(3 * (n + i), 3 * (n + j)) = rotation;
      mobility.block<3, 3>(3 * (n + j), 3 * (n + i)) = rotation;
      // U_i from T_j, Ω_i from F_j; seen from j the separation has the other sign.
      mobility.block<3, 3>(3 * i, 3 * (n + j)) = mixed;
      mobility.block<3, 3>(3 * (n + i), 3 * j) = mixed;
      mobility.block<3, 3>(3 * j, 3 * (n + i)) = -mixed;
      mobility.block<3, 3>(3 * (n + j), 3 * i) = -mixed;
    }
  }
  return mobility;
}

void add_plane_images(Eigen::MatrixXd& mobility, const NoSlipPlane& plane, const Eigen::Matrix3Xd& position_m,
                      std::span<const double> radius_m, double viscosity_Pa_s) {
  const Eigen::Index n = position_m.cols();
  const Eigen::Matrix3Xd position_P_m = plane.rotation * (position_m.colwise() - plane.origin_m);
  const auto radius = [&radius_m](Eigen::Index i) { return radius_m[i]; };
  for (Eigen::Index i = 0; i < n; ++i)
    if (!(position_P_m(2, i) > radius(i)))
      throw SolverError(
          "sphere " + std::to_string(i) +
          " reaches the no-slip plane (Stokes mobility is not defined then). Use weaker forces or start further away.");
  const auto in_world = [&plane](const Eigen::Matrix3d& tensor_P) -> Eigen::Matrix3d {
    return plane.rotation.transpose() * tensor_P * plane.rotation;
  };
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const ImageMobility images =
          image_mobility(position_P_m.col(i), radius(i), position_P_m.col(j), radius(j), viscosity_Pa_s);
      const Eigen::Matrix3d rt = in_world(images.rt);
      mobility.block<3, 3>(3 * i, 3 * j) += in_world(images.tt);
      mobility.block<3, 3>(3 * (n + i), 3 * (n + j)) += in_world(images.rr);
      mobility.block<3, 3>(3 * (n + i), 3 * j) += rt;
      mobility.block<3, 3>(3 * j, 3 * (n + i)) += rt.transpose();  // Lorentz reciprocity
    }
}

StokesFlow::StokesFlow(const FluidSetup& setup, const Communicator& communicator)
    : StatelessFluid("stokes", setup, communicator),
      viscosity_Pa_s_(setup.density_kg_per_m3 * setup.kinematic_viscosity_m2_per_s) {
  if (setup.no_slip_plane >= 0) plane_ = no_slip_plane_of(setup);
  for (const Shape& shape : setup.bodies) {
    if (shape.kind != ShapeKind::sphere)
      throw CaseError(
          "a body is not a sphere (solver: stokes has the mobility of spheres only). Use solver: lattice_boltzmann.");
    radius_m_.push_back(shape.radius_m);
  }
}

void StokesFlow::add_loads(const Kinematics& kinematics, Loads& loads) {
  const double start_s = now_s();
  const Eigen::Index n = kinematics.bodies();
  Eigen::VectorXd motion(6 * n);
  motion << kinematics.velocity_m_per_s.reshaped(), kinematics.angular_velocity_rad_per_s.reshaped();
  Eigen::MatrixXd mobility = grand_mobility(kinematics.position_m, radius_m_, viscosity_Pa_s_);
  if (plane_) add_plane_images(mobility, *plane_, kinematics.position_m, radius_m_, viscosity_Pa_s_);
  const Eigen::LLT<Eigen::MatrixXd> factors(mobility);
  const Eigen::VectorXd load = factors.solve(-motion);
  if (factors.info() != Eigen::Success || !load.allFinite())
    throw SolverError(
        "the Stokes mobility cannot be inverted (positions or velocities are not finite). Use a shorter step_s.", 0,
        kinematics.step);
  loads.force_N.reshaped() = load.head(3 * n);
  loads.torque_N_m.reshaped() = load.tail(3 * n);
  exchange_s_ += now_s() - start_s;
}

SolverSummary StokesFlow::summarise() {
  SolverSummary summary = StatelessFluid::summarise();
  summary.seconds["mobility"] = exchange_s_;
  return summary;
}

}  // namespace copepod::fluid
