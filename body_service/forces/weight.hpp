#pragma once

#include <Eigen/Core>

namespace copepod::body {

/// Gravity less hydrostatic buoyancy,
///   F = (m − ρ V) g                                                                    (B8)
/// The fluid solver computes without gravity, so that its loads are the hydrodynamic part alone.
/// @return force on the body, world frame [N]
inline Eigen::Vector3d buoyant_weight(double mass_kg, double volume_m3, double fluid_density_kg_per_m3,
                                      const Eigen::Vector3d& gravity_m_per_s2) {
  return (mass_kg - fluid_density_kg_per_m3 * volume_m3) * gravity_m_per_s2;
}

}  // namespace copepod::body
