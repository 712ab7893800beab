#pragma once

#include <algorithm>

#include "model/body_model.hpp"

namespace copepod::body {

/// Units in which an engine computes: its built-in margins and thresholds are made for bodies of about one unit, ours
/// measure micrometres and nanoseconds.
///   length L: the smallest radius,   mass M: the smallest mass,   time T: chosen by the engine
///   F' = F T²/(M L),   τ' = τ T²/(M L²),   v' = v T/L,   ω' = ω T
struct EngineUnits {
  double length_m = 1.0;
  double mass_kg = 1.0;
  double time_s = 1.0;

  [[nodiscard]] double force_N() const { return mass_kg * length_m / (time_s * time_s); }
  [[nodiscard]] double torque_N_m() const { return force_N() * length_m; }
  [[nodiscard]] double velocity_m_per_s() const { return length_m / time_s; }
  [[nodiscard]] double inertia_kg_m2() const { return mass_kg * length_m * length_m; }
};

/// @param time_s  positive
inline EngineUnits engine_units(const BodyModel& model, double time_s) {
  EngineUnits units{1.0, 1.0, time_s};
  for (Eigen::Index body = 0; body < model.bodies(); ++body) {
    const double radius_m = model.shape(body).radius_m;
    const double mass_kg = 1.0 / model.inverse_mass_per_kg(body);
    units.length_m = body == 0 ? radius_m : std::min(units.length_m, radius_m);
    units.mass_kg = body == 0 ? mass_kg : std::min(units.mass_kg, mass_kg);
  }
  return units;
}

}  // namespace copepod::body
