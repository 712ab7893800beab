#include "scheme/lubrication.hpp"

#include <algorithm>

#include <Eigen/Geometry>

#include "geometry/rotation.hpp"

namespace copepod::coupler {

double Lubrication::Motion::damping_per_s(const FilmContact& contact) const {
  const Eigen::Vector3d arm_m = contact.point_m - centre_m;
  const auto by = [&](double resistance_N_s_per_m, double squared_arm_m2) {
    return resistance_N_s_per_m * (mobility.per_mass_per_kg + squared_arm_m2 * mobility.per_inertia_per_kg_m2);
  };
  return by(contact.squeezing_N_s_per_m, arm_m.cross(contact.normal).squaredNorm()) +
         by(1.6 * contact.shear_N_s_per_m, arm_m.squaredNorm());
}

Lubrication::Lubrication(const FluidSetup& fluid, const std::vector<BodySpecification>& bodies, double roughness_m)
    : fluid_(fluid), roughness_m_(roughness_m) {
  if (!(fluid.film_thickness_m > 0.0)) return;
  for (const BodySpecification& body : bodies) {
    mobilities_.emplace_back();
    if (body.motion != MotionKind::free && body.motion != MotionKind::axis) continue;
    const MomentsOfInertia moments = moments_of_inertia(body.shape, body.mass_kg);
    mobilities_.back() = {1.0 / body.mass_kg, 1.0 / std::min(moments.along_kg_m2, moments.across_kg_m2)};
  }
  surfaces_.emplace(fluid, FilmRange(fluid).high_m);
  films_.resize(static_cast<Eigen::Index>(bodies.size()));
}

void Lubrication::add_to(Loads& raw, Loads& averaged, const Kinematics& kinematics) {
  if (!surfaces_) return;
  films_.force_N.setZero();
  films_.torque_N_m.setZero();
  surfaces_->find(kinematics);
  for (std::size_t body = 0; body < mobilities_.size(); ++body)
    for (const NearSurface& surface : surfaces_->of_body(body)) add_film(body, surface, kinematics);
  for (Loads* loads : {&raw, &averaged}) {
    loads->force_N += films_.force_N;
    loads->torque_N_m += films_.torque_N_m;
  }
}

Lubrication::Motion Lubrication::motion_of(std::size_t body, const Kinematics& kinematics) const {
  const auto column = static_cast<Eigen::Index>(body);
  return {Eigen::Vector3d::Zero(), kinematics.velocity_m_per_s.col(column),
          kinematics.angular_velocity_rad_per_s.col(column), mobilities_[body]};
}

Lubrication::Motion Lubrication::motion_of(const NearSurface& surface, const Kinematics& kinematics) const {
  if (surface.other < 0) {
    const Boundary& wall = fluid_.boundaries[static_cast<std::size_t>(surface.face)];
    Motion motion;
    if (wall.kind == BoundaryKind::velocity) motion.velocity_m_per_s = wall.velocity_m_per_s;
    return motion;
  }
  Motion motion = motion_of(static_cast<std::size_t>(surface.other), kinematics);
  motion.centre_m = surface.core.centre_W_m;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (!surface.mirrored[static_cast<std::size_t>(axis)]) continue;
    motion.velocity_m_per_s[axis] *= -1.0;
    motion.angular_velocity_rad_per_s *= -1.0;
    motion.angular_velocity_rad_per_s[axis] *= -1.0;
  }
  return motion;
}

/// As seen from the body of the lower number, so that a pair's loads are opposite.
void Lubrication::find_contacts(std::size_t body, const NearSurface& surface, const Kinematics& kinematics) {
  const Shape& shape = fluid_.bodies[body];
  NearSurface own{.other = static_cast<int>(body), .core = {}, .radius_m = shape.radius_m};
  own.core.centre_W_m.setZero();
  own.core.half_W_m =
      core_half_length_m(shape) * z_axis(kinematics.orientation_wxyz.col(static_cast<Eigen::Index>(body)));
  const FilmRange range(fluid_);
  const double viscosity_Pa_s = fluid_.density_kg_per_m3 * fluid_.kinematic_viscosity_m2_per_s;
  if (surface.other < 0 || surface.other >= own.other) {
    find_film(own.core, own.radius_m, surface, range, viscosity_Pa_s, roughness_m_, contacts_);
    return;
  }
  find_film(surface.core, surface.radius_m, own, range, viscosity_Pa_s, roughness_m_, contacts_);
  for (FilmContact& contact : contacts_) {
    contact.normal *= -1.0;
    contact.curvature_share = 1.0 - contact.curvature_share;
  }
}

void Lubrication::add_film(std::size_t body, const NearSurface& surface, const Kinematics& kinematics) {
  find_contacts(body, surface, kinematics);
  const Motion own = motion_of(body, kinematics);
  const Motion other = motion_of(surface, kinematics);
  const Eigen::Vector3d turning_rad_per_s = own.angular_velocity_rad_per_s - other.angular_velocity_rad_per_s;
  double damping = 0.0;  // of the relative motion in one step
  for (const FilmContact& contact : contacts_)
    damping += fluid_.step_s * (own.damping_per_s(contact) + other.damping_per_s(contact));
  const double limit = std::min(1.0, 0.5 / damping);
  const auto column = static_cast<Eigen::Index>(body);
  for (const FilmContact& contact : contacts_) {
    const Eigen::Vector3d& n = contact.normal;
    const Eigen::Vector3d relative_m_per_s =
        own.velocity_at_m_per_s(contact.point_m) - other.velocity_at_m_per_s(contact.point_m);
    const double W = relative_m_per_s.dot(n);
    const Eigen::Vector3d v = relative_m_per_s - W * n;
    const double s = contact.curvature_share;
    const double R = contact.radius_m;
    const double S = contact.shear_N_s_per_m;
    const double P = contact.pressure_N_s_per_m;
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    if (R > 0.0) u = (1.0 - 2.0 * s) * v + 2.0 * R * n.cross(turning_rad_per_s);
    const Eigen::Vector3d force_N =
        limit * (-contact.squeezing_N_s_per_m * W * n - S * v + ((1.2 * s - 0.6) * S + 1.2 * (1.0 - s) * P) * u);
    films_.force_N.col(column) += force_N;
    films_.torque_N_m.col(column) += contact.point_m.cross(force_N) - limit * 1.2 * R * (S - P) * u.cross(n);
  }
}

}  // namespace copepod::coupler
