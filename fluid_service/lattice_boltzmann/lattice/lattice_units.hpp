#pragma once

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"

namespace copepod::fluid {

/// The only place where SI and lattice units meet. Cell size Δx, step Δt and density ρ₀ are the units.
class LatticeUnits {
 public:
  explicit LatticeUnits(const FluidSetup& setup)
      : cell_m_(setup.cell_size_m), step_s_(setup.step_s), density_(setup.density_kg_per_m3) {}

  /// x_lu = x / Δx
  [[nodiscard]] Eigen::Vector3d position_lu(const Eigen::Vector3d& x_m) const { return x_m / cell_m_; }
  [[nodiscard]] Eigen::Vector3d position_m(const Eigen::Vector3d& x_lu) const { return x_lu * cell_m_; }
  [[nodiscard]] double length_lu(double length_m) const { return length_m / cell_m_; }
  /// u_lu = u Δt / Δx
  [[nodiscard]] Eigen::Vector3d velocity_lu(const Eigen::Vector3d& u_m_per_s) const {
    return u_m_per_s * (step_s_ / cell_m_);
  }
  /// ω_lu = ω Δt
  [[nodiscard]] Eigen::Vector3d angular_velocity_lu(const Eigen::Vector3d& w_rad_per_s) const {
    return w_rad_per_s * step_s_;
  }
  /// ν_lu = ν Δt / Δx²
  [[nodiscard]] double viscosity_lu(double nu_m2_per_s) const { return nu_m2_per_s * step_s_ / (cell_m_ * cell_m_); }
  /// τ = 3 ν_lu + 1/2
  [[nodiscard]] double relaxation_time(double nu_m2_per_s) const { return 3.0 * viscosity_lu(nu_m2_per_s) + 0.5; }
  /// Force per volume: g_lu = g Δt² / (ρ₀ Δx)
  [[nodiscard]] Eigen::Vector3d body_force_lu(const Eigen::Vector3d& g_N_per_m3) const {
    return g_N_per_m3 * (step_s_ * step_s_ / (density_ * cell_m_));
  }
  /// ρ_lu − 1 = 3 p Δt² / (ρ₀ Δx²)
  [[nodiscard]] double excess_density_lu(double pressure_Pa) const {
    return 3.0 * pressure_Pa * step_s_ * step_s_ / (density_ * cell_m_ * cell_m_);
  }
  /// p = c_s² (ρ − ρ₀) Δx² / Δt²,   c_s² = 1/3, relative to fluid at rest
  [[nodiscard]] double pressure_Pa(double density_kg_per_m3) const {
    return (density_kg_per_m3 - density_) * (cell_m_ * cell_m_ / (3.0 * step_s_ * step_s_));
  }
  /// F = F_lu ρ₀ Δx⁴ / Δt²
  [[nodiscard]] double force_N(double force_lu) const {
    return force_lu * (density_ * cell_m_ * cell_m_ * cell_m_ * cell_m_ / (step_s_ * step_s_));
  }
  /// T = T_lu ρ₀ Δx⁵ / Δt²
  [[nodiscard]] double torque_N_m(double torque_lu) const { return force_N(torque_lu) * cell_m_; }
  /// ρ = ρ_lu ρ₀
  [[nodiscard]] double density_kg_per_m3(double density_lu) const { return density_lu * density_; }
  /// u = u_lu Δx / Δt
  [[nodiscard]] double velocity_m_per_s(double velocity_lu) const { return velocity_lu * (cell_m_ / step_s_); }

 private:
  double cell_m_;
  double step_s_;
  double density_;
};

}  // namespace copepod::fluid
