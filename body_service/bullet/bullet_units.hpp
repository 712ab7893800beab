#pragma once

#include <LinearMath/btVector3.h>
#include <algorithm>

#include <Eigen/Core>

#include "model/body_model.hpp"

namespace copepod::body {

/// Units in which Bullet computes: its built-in margins (0.02 of a length unit for contacts) are made for
/// bodies of about one unit, ours measure micrometres and nanoseconds.
///   length L: the smallest radius,   mass M: the smallest mass,   time T: the step
///   F' = F T²/(M L),   τ' = τ T²/(M L²),   v' = v T/L,   ω' = ω T
struct BulletUnits {
  double length_m = 1.0;
  double mass_kg = 1.0;
  double time_s = 1.0;

  [[nodiscard]] double force_N() const { return mass_kg * length_m / (time_s * time_s); }
  [[nodiscard]] double velocity_m_per_s() const { return length_m / time_s; }
};

/// @param step_s  positive
inline BulletUnits bullet_units(const BodyModel& model, double step_s) {
  BulletUnits units{1.0, 1.0, step_s};
  for (Eigen::Index body = 0; body < model.bodies(); ++body) {
    const double radius_m = model.shape(body).radius_m;
    const double mass_kg = 1.0 / model.inverse_mass_per_kg(body);
    units.length_m = body == 0 ? radius_m : std::min(units.length_m, radius_m);
    units.mass_kg = body == 0 ? mass_kg : std::min(units.mass_kg, mass_kg);
  }
  return units;
}

/// A vector in SI units as Bullet's, divided by the unit it is measured in.
inline btVector3 to_bullet(const Eigen::Vector3d& vector, double unit) {
  return {vector[0] / unit, vector[1] / unit, vector[2] / unit};
}

inline Eigen::Vector3d from_bullet(const btVector3& vector, double unit) {
  return {vector.x() * unit, vector.y() * unit, vector.z() * unit};
}

}  // namespace copepod::body
