#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "contract/body_setup.hpp"

namespace copepod {

/// Substeps within half a period of the fastest contact spring: restitution then comes out within 0.5 %
/// [docs/decisions/contacts.md].
inline constexpr double substeps_per_contact = 40.0;

/// Share of turning in the inverse of the effective mass of a body's contact, the largest over its surface [1/kg],
///   (r × n)ᵀ I⁻¹ (r × n);   of capsules a²/I_across, a the distance of their ends from the centre
double largest_turning_per_kg(const BodySpecification& body);

/// Largest inverse of the effective mass of a contact, 1/m_eff = Σ (1/m + turning) over both bodies [1/kg]; 0 if no
/// body moves.
inline double largest_inverse_mass_per_kg(const std::vector<BodySpecification>& bodies) {
  double largest = 0.0;
  for (const BodySpecification& body : bodies) {
    if (body.motion != MotionKind::free && body.motion != MotionKind::axis) continue;
    largest = std::max(largest, 1.0 / body.mass_kg + largest_turning_per_kg(body));
  }
  return 2.0 * largest;
}

/// Shortest duration of an undamped contact, T = π √(m_eff/k) [s]                                          (B22)
/// @param stiffness_N_per_m    positive
/// @param inverse_mass_per_kg  see largest_inverse_mass_per_kg, positive
inline double shortest_contact_s(double stiffness_N_per_m, double inverse_mass_per_kg) {
  return std::numbers::pi / std::sqrt(stiffness_N_per_m * inverse_mass_per_kg);
}

/// Its inverse: the stiffness of contacts that last that long [N/m].
inline double stiffness_of_contact(double duration_s, double inverse_mass_per_kg) {
  const double frequency_rad_per_s = std::numbers::pi / duration_s;
  return frequency_rad_per_s * frequency_rad_per_s / inverse_mass_per_kg;
}

/// Substeps into which bodies with these contacts divide a step; a whole number, at least 1.
inline double contact_substeps(const BodySetup& setup) {
  const double inverse_mass_per_kg = largest_inverse_mass_per_kg(setup.bodies);
  if (setup.contact.stiffness_N_per_m <= 0.0 || inverse_mass_per_kg == 0.0) return 1.0;
  const double shortest_s = shortest_contact_s(setup.contact.stiffness_N_per_m, inverse_mass_per_kg);
  constexpr double rounding = 1e-9;
  return std::max(1.0, std::ceil(setup.step_s * substeps_per_contact / shortest_s * (1.0 - rounding)));
}

}  // namespace copepod
