#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "scheme/lubrication.hpp"

namespace copepod::coupler {
namespace {

using std::numbers::pi;

/// A surface as seen from a point: the sphere, cylinder or plane that is nearest.
struct NearestPoint {
  Eigen::Vector3d normal;   ///< from the surface to the point
  double distance_m = 0.0;  ///< of the point from the surface
  double curvature_per_m = 0.0;
  Eigen::Vector3d axis{0, 0, 0};  ///< of a cylinder; zero for a sphere and a plane

  /// Distance of the surface from the point against a unit vector, which points away from the surface; infinity if
  /// there is none:  |w − s t| = 1/k, with w = n (d + 1/k) from the centre or the axis, and t normal to the axis
  [[nodiscard]] double distance_along_m(const Eigen::Vector3d& away) const {
    if (curvature_per_m == 0.0) return distance_m / std::max(normal.dot(away), 1e-9);
    const double radius_m = 1.0 / curvature_per_m;
    const double from_core_m = distance_m + radius_m;
    const Eigen::Vector3d t = away - away.dot(axis) * axis;
    const double linear = from_core_m * normal.dot(t);
    const double square = t.squaredNorm();
    const double discriminant = linear * linear - square * (from_core_m * from_core_m - radius_m * radius_m);
    if (discriminant <= 0.0 || linear <= 0.0) return std::numeric_limits<double>::infinity();
    return (from_core_m * from_core_m - radius_m * radius_m) / (linear + std::sqrt(discriminant));
  }
};

NearestPoint nearest_point(const NearSurface& surface, const Eigen::Vector3d& point_m) {
  if (!surface.is_body()) return {surface.normal, surface.from(point_m).m, 0.0};
  const Eigen::Vector3d& half_m = surface.core.half_W_m;
  const Eigen::Vector3d from_centre_m = point_m - surface.core.centre_W_m;
  const double length_m = half_m.norm();
  const Eigen::Vector3d axis = length_m > 0.0 ? Eigen::Vector3d(half_m / length_m) : Eigen::Vector3d::Zero();
  const double along_m = std::clamp(axis.dot(from_centre_m), -length_m, length_m);
  const Eigen::Vector3d across_m = from_centre_m - along_m * axis;
  const double distance_m = across_m.norm();
  return {across_m / distance_m, distance_m - surface.radius_m, 1.0 / surface.radius_m,
          std::abs(along_m) < length_m ? axis : Eigen::Vector3d::Zero()};
}

/// Iₙ = ∫ (1 − w) dh/hⁿ from h₀ on, w rising linearly from low to high.
struct FilmIntegrals {
  double I0 = 0.0;
  double I1 = 0.0;
  double I2 = 0.0;

  FilmIntegrals(double h0, const FilmRange& range) {
    const double low = std::max(h0, range.low_m);
    const double high = range.high_m;
    const double width = range.high_m - range.low_m;
    I0 = (low - h0) + 0.5 * (high - low) * (high - low) / width;
    I1 = std::log(low / h0) + (high * std::log(high / low) - (high - low)) / width;
    I2 = (1.0 / h0 - 1.0 / low) + (high * (1.0 / low - 1.0 / high) - std::log(high / low)) / width;
  }
};

/// Jₙ = ∫ (1 − w) dx/hⁿ across a slice, h = h₀ + λx²/2: the mean over cut-offs h_c from low to high of
///   J₁ = 2 atan(x_c √(λ/2h₀)) / √(λh₀/2),   J₂ = x_c/(h₀h_c) + atan(x_c √(λ/2h₀)) / (h₀ √(λh₀/2)),   h(x_c) = h_c
struct SliceIntegrals {
  double J1 = 0.0;
  double J2 = 0.0;

  SliceIntegrals(double h0, double curvature, const FilmRange& range) {
    constexpr int cut_offs = 4;
    const double root = std::sqrt(0.5 * curvature * h0);
    for (int i = 0; i < cut_offs; ++i) {
      const double cut_off = range.low_m + (range.high_m - range.low_m) * (i + 0.5) / cut_offs;
      if (cut_off <= h0) continue;
      const double x = std::sqrt(2.0 * (cut_off - h0) / curvature);
      const double angle = std::atan(x * root / h0);
      J1 += 2.0 * angle / root / cut_offs;
      J2 += (x / cut_off + angle / root) / h0 / cut_offs;
    }
  }
};

class FilmFinder {
 public:
  FilmFinder(double radius_m, const NearSurface& second, const FilmRange& range, double viscosity_Pa_s,
             const FilmLimits& limits, std::vector<FilmContact>& contacts)
      : radius_m_(radius_m),
        second_(second),
        range_(range),
        viscosity_Pa_s_(viscosity_Pa_s),
        limits_(limits),
        contacts_(contacts) {}

  /// @param outward  away from the rest of a capsule; zero: a whole sphere
  void add_sphere(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& outward) const {
    const NearestPoint from = nearest_point(second_, centre_m);
    const double gap_m = from.distance_m - radius_m_;
    const double h0 = std::max(gap_m, limits_.roughness_m);
    if (h0 >= range_.high_m) return;
    const double k1 = 1.0 / radius_m_;
    const double k2 = from.curvature_per_m;
    const double along_axis = from.axis.isZero(0.0) ? k1 + k2 : k1;
    const double R = 2.0 / (k1 + k2 + along_axis);
    // The half sphere is half of the film of a sphere that lies beside the capsule, and all of it at its end.
    const double film_radius_m = std::sqrt(2.0 * R * h0);
    const double part = outward.isZero(0.0)
                            ? 1.0
                            : std::clamp(0.5 - 0.5 * outward.dot(from.normal) * radius_m_ / film_radius_m, 0.0, 1.0);
    const Eigen::Vector3d point_m = centre_m - from.normal * (0.5 * (radius_m_ + from.distance_m));
    add_cap(point_m, from.normal, gap_m, {k1, k2, R, part * (2.0 * pi / std::sqrt((k1 + k2) * along_axis))});
  }

  /// Of spheres and ellipsoids one of which is an ellipsoid, by the curvatures at the points that are nearest.
  void add_ellipsoid(const SmoothSurface& first) const {
    Separation nearest{second_.normal, second_.from(first.support_m(-second_.normal)).m};
    if (second_.is_body()) nearest = separation(first, second_.smooth(), range_.high_m);
    const Eigen::Vector3d& n = nearest.normal;
    Eigen::Matrix<double, 3, 2> across;
    across.col(0) = n.unitOrthogonal();
    across.col(1) = n.cross(across.col(0));
    const auto curvatures_per_m = [&](const SmoothSurface& surface) -> Eigen::Matrix2d {
      return (across.transpose() * surface.radii_m(n) * across).inverse();
    };
    const Eigen::Matrix2d K1 = curvatures_per_m(first);
    const Eigen::Matrix2d K2 = second_.is_body() ? curvatures_per_m(second_.smooth()) : Eigen::Matrix2d::Zero().eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> K(K1 + K2);
    const Eigen::Vector2d& k = K.eigenvalues();
    const double R = 2.0 / k.sum();
    // An ellipsoid is h₀ + s + s²/2H thick where its parabola is h₀ + s, with H from the point to the centre along n.
    const auto bluntness = [&](const SmoothSurface& surface, double mean_per_m) {
      const double height_m = n.dot(surface.support_m(n) - surface.centre_m);
      return std::pow(mean_per_m * R, 2) * R * (1.0 / height_m - mean_per_m);
    };
    const double k1 = 0.5 * K1.trace(), k2 = 0.5 * K2.trace();
    const Eigen::Vector3d point_m = first.support_m(-n) - 0.5 * nearest.gap_m * n;
    add_cap(point_m, n, nearest.gap_m,
            {.k1 = k1,
             .k2 = k2,
             .R = R,
             .area = 2.0 * pi / std::sqrt(k.prod()),
             .bluntness = bluntness(first, k1) + (k2 > 0.0 ? bluntness(second_.smooth(), k2) : 0.0),
             .kappa = k * R,
             .along = across * K.eigenvectors().col(0)});
  }

  void add_slices(const CoreSegment& first) const {
    constexpr int slices = 32;
    const double half_length_m = first.half_W_m.norm();
    const Eigen::Vector3d axis = first.half_W_m / half_length_m;
    // Narrow where the film is thinnest, in proportion to the distance from there further away.
    double nearest_place_m = 0.0;
    double smallest_m = nearest_point(second_, first.centre_W_m).distance_m;
    const auto consider = [&](double place_m) {
      const double distance_m = nearest_point(second_, first.centre_W_m + place_m * axis).distance_m;
      if (distance_m >= smallest_m) return;
      smallest_m = distance_m;
      nearest_place_m = place_m;
    };
    consider(half_length_m);
    consider(-half_length_m);
    if (second_.is_body()) consider(half_length_m * nearest_place(first, second_.core));
    const double width_m = std::sqrt(2.0 * radius_m_ * std::max(smallest_m - radius_m_, limits_.roughness_m));
    const double low = std::asinh((-half_length_m - nearest_place_m) / width_m);
    const double high = std::asinh((half_length_m - nearest_place_m) / width_m);
    double place_m = -half_length_m;
    for (int i = 1; i <= slices; ++i) {
      const double next_m = nearest_place_m + width_m * std::sinh(low + (high - low) * i / slices);
      add_slice(first.centre_W_m + 0.5 * (place_m + next_m) * axis, axis, next_m - place_m);
      place_m = next_m;
    }
  }

 private:
  /// 0: what is left of the film does not resist the approach.
  [[nodiscard]] double squeezed(double gap_m) const { return limits_.end_at_contact && gap_m < 0.0 ? 0.0 : 1.0; }

  /// Between two cross sections of a cylinder.
  void add_slice(const Eigen::Vector3d& point_m, const Eigen::Vector3d& axis, double length_m) const {
    const NearestPoint from = nearest_point(second_, point_m);
    const Eigen::Vector3d across = from.normal - from.normal.dot(axis) * axis;
    if (across.norm() < 1e-6) return;  // the surface is beyond the end
    const Eigen::Vector3d normal = across.normalized();
    const double distance_m = from.distance_along_m(normal);
    const double gap_m = distance_m - radius_m_;
    const double h0 = std::max(gap_m, limits_.roughness_m);
    if (h0 >= range_.high_m) return;
    const double k1 = 1.0 / radius_m_;
    const double k2 = from.curvature_per_m;
    const double along_second = from.axis.dot(axis.cross(normal));
    const auto [J1, J2] = SliceIntegrals(h0, k1 + k2 * (1.0 - along_second * along_second), range_);
    contacts_.push_back({.point_m = point_m - normal * (0.5 * (radius_m_ + distance_m)),
                         .normal = normal,
                         .gap_m = gap_m,
                         .squeezing_N_s_per_m = squeezed(gap_m) * 6.0 * viscosity_Pa_s_ / (k1 + k2) * J2 * length_m,
                         .sliding_N_s_per_m = Eigen::Vector2d::Constant(viscosity_Pa_s_ * J1 * length_m)});
  }

  /// A film h₀ + ρᵀKρ/2 around its thinnest point.
  struct Cap {
    double k1, k2;                   ///< mean curvatures of the surfaces
    double R;                        ///< radius of the mean of K
    double area;                     ///< dA/dh
    double bluntness = 0.0;          ///< by how much it is thicker than between spheres of these curvatures
    Eigen::Array2d kappa{1, 1};      ///< principal curvatures of K over the mean
    Eigen::Vector3d along{0, 0, 0};  ///< of the first of them
  };

  void add_cap(const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal, double gap_m, const Cap& cap) const {
    const double h0 = std::max(gap_m, limits_.roughness_m);
    if (h0 >= range_.high_m) return;
    const auto& [k1, k2, R, area, bluntness, kappa, along] = cap;
    const Eigen::Array2d g = 5.0 / (3.0 * kappa + 2.0 * kappa.reverse());
    const auto [I0, I1, I2] = FilmIntegrals(h0, range_);
    const double q = (k1 - k2) / (k1 + k2);
    const double inner = I1 - h0 * I2;
    const double one_sided = second_.is_body() && !second_.is_mirrored() ? 0.0 : 1.0;
    const double size = I0 / R;
    const double rim = (range_.high_m - h0) / R;
    const double even = 1.0 - q * q;
    const double viscous = area * viscosity_Pa_s_;
    contacts_.push_back({.point_m = point_m,
                         .normal = normal,
                         .gap_m = gap_m,
                         .squeezing_N_s_per_m = squeezed(gap_m) * 3.0 * viscous *
                                                (R * I2 + (0.2 + k1 * k2 * R * R - 0.75 * bluntness) * I1 +
                                                 0.6 * (1.0 - h0 / range_.high_m)),
                         .sliding_N_s_per_m = viscous * (I1 + 0.6 * kappa * g * q * q * (inner + one_sided * h0 * I2) +
                                                         0.6 * even * size + 0.57 * q * q * kappa * rim),
                         .force_of_turning_N_s =
                             viscous * R * (1.2 * g * (q * inner + one_sided * h0 * I2) + (0.5 - one_sided) * q * size),
                         .torque_of_sliding_N_s = viscous * R * q * (1.2 * g * inner + (0.5 + one_sided) * size),
                         .turning_N_m_s = viscous * R * R * (2.4 * g / kappa * inner + (1.2 - 0.7 * even) * size),
                         .spinning_N_m_s = viscous * R * (2.0 * (I0 - h0 * I1) + 0.6 * even * I0),
                         .along = along});
  }

  double radius_m_;
  const NearSurface& second_;
  const FilmRange& range_;
  double viscosity_Pa_s_;
  FilmLimits limits_;
  std::vector<FilmContact>& contacts_;
};

}  // namespace

double FilmContact::normal_velocity(const Eigen::Vector<double, 6>& motion) const {
  return normal.dot(motion.head<3>() + motion.tail<3>().cross(point_m));
}

Eigen::Matrix<double, 6, 6> FilmContact::resistance() const {
  const auto cross = [](const Eigen::Vector3d& vector) {
    Eigen::Matrix3d matrix;
    matrix << 0, -vector[2], vector[1], vector[2], 0, -vector[0], -vector[1], vector[0], 0;
    return matrix;
  };
  const Eigen::Matrix3d along_normal = normal * normal.transpose();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along_normal;
  const Eigen::Matrix3d n = cross(normal);
  const Eigen::Matrix3d x = cross(point_m);
  Eigen::Matrix3d F_v = squeezing_N_s_per_m * along_normal + sliding_N_s_per_m[1] * across;
  Eigen::Matrix3d F_w = -force_of_turning_N_s[1] * n;
  Eigen::Matrix3d T_v = torque_of_sliding_N_s[1] * n;
  Eigen::Matrix3d T_w = turning_N_m_s[0] * across + spinning_N_m_s * along_normal;  // along e is about n × e
  if (!along.isZero(0.0)) {
    const auto difference = [](const Eigen::Vector2d& values) { return values[0] - values[1]; };
    const Eigen::Matrix3d ee = along * along.transpose();
    F_v += difference(sliding_N_s_per_m) * ee;
    F_w -= difference(force_of_turning_N_s) * ee * n;
    T_v += difference(torque_of_sliding_N_s) * n * ee;
    T_w -= difference(turning_N_m_s) * ee;
  }
  // About the origin: v = V + Δω × x, T = T_x + x × F.
  Eigen::Matrix<double, 6, 6> result;
  result << F_v, F_w - F_v * x, T_v + x * F_v, T_w - T_v * x + x * (F_w - F_v * x);
  return result;
}

void find_film(const NearSurface& first, const NearSurface& second, const FilmRange& range, double viscosity_Pa_s,
               const FilmLimits& limits, std::vector<FilmContact>& contacts) {
  contacts.clear();
  const FilmFinder film(first.radius_m, second, range, viscosity_Pa_s, limits, contacts);
  const auto& [centre_m, half_m] = first.core;
  if (first.is_ellipsoid() || second.is_ellipsoid()) {
    film.add_ellipsoid(first.smooth());
  } else if (half_m.isZero(0.0)) {
    film.add_sphere(centre_m, Eigen::Vector3d::Zero());
  } else {
    for (const double end : {-1.0, 1.0}) film.add_sphere(centre_m + end * half_m, end * half_m.normalized());
    film.add_slices(first.core);
  }
}

}  // namespace copepod::coupler
