#pragma once

#include "contract/body_setup.hpp"
#include "forces/force_element.hpp"

namespace copepod::body {

/// Gravity less hydrostatic buoyancy,
///   F = (m − ρ V) g                                                                    (B8)
/// The fluid solver computes without gravity, so that its loads are the hydrodynamic part alone.
/// @return force on the body, world frame [N]
inline Eigen::Vector3d buoyant_weight(double mass_kg, double volume_m3, double fluid_density_kg_per_m3,
                                      const Eigen::Vector3d& gravity_m_per_s2) {
  return (mass_kg - fluid_density_kg_per_m3 * volume_m3) * gravity_m_per_s2;
}

/// Weight less buoyancy of every body.
class Weight final : public ForceElement {
 public:
  explicit Weight(const BodySetup& setup) : force_N_(3, static_cast<Eigen::Index>(setup.bodies.size())) {
    for (Eigen::Index body = 0; body < force_N_.cols(); ++body) {
      const BodySpecification& specification = setup.bodies[static_cast<std::size_t>(body)];
      force_N_.col(body) = buoyant_weight(specification.mass_kg, volume_m3(specification.shape),
                                          setup.fluid_density_kg_per_m3, setup.gravity_m_per_s2);
    }
  }

  /// [N], world frame, shape (3, bodies)
  [[nodiscard]] const BlockVectors& force_N() const { return force_N_; }

  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors&) const override {
    force_N.leftCols(stage.block.bodies) += force_N_.middleCols(stage.block.first, stage.block.bodies);
  }

 private:
  BlockVectors force_N_;
};

}  // namespace copepod::body
