#include "stokes/grand_mobility.hpp"

#include <numbers>
#include <string>

#include "contract/errors.hpp"

namespace copepod::fluid {

namespace {

using std::numbers::pi;

/// The matrix of v ↦ v × r.
Eigen::Matrix3d cross_with(const Eigen::Vector3d& r) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, r[2], -r[1], -r[2], 0.0, r[0], r[1], -r[0], 0.0;
  return matrix;
}

}  // namespace

Eigen::MatrixXd grand_mobility(const Eigen::Matrix3Xd& position_m, std::span<const double> radius_m,
                               double viscosity_Pa_s) {
  const Eigen::Index n = position_m.cols();
  const double eta = viscosity_Pa_s;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  Eigen::MatrixXd mobility = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double a = radius_m[static_cast<std::size_t>(i)];
    mobility.block<3, 3>(3 * i, 3 * i) = unit / (6.0 * pi * eta * a);
    mobility.block<3, 3>(3 * (n + i), 3 * (n + i)) = unit / (8.0 * pi * eta * a * a * a);
    for (Eigen::Index j = 0; j < i; ++j) {
      const double b = radius_m[static_cast<std::size_t>(j)];
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
  const auto radius = [&radius_m](Eigen::Index i) { return radius_m[static_cast<std::size_t>(i)]; };
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(position_P_m(2, i) > radius(i)))
      throw SolverError("sphere " + std::to_string(i) +
                        " reaches the no-slip plane (Stokes mobility is not defined then). Use weaker forces or "
                        "start further away.");
  }
  const auto in_world = [&plane](const Eigen::Matrix3d& tensor_P) -> Eigen::Matrix3d {
    return plane.rotation.transpose() * tensor_P * plane.rotation;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
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
}

}  // namespace copepod::fluid
