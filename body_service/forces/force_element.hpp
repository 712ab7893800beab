#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "model/body_block.hpp"
#include "model/motion_state.hpp"
#include "model/vector_loops.hpp"

namespace copepod::body {

/// Lengths and directions of the lines of a block (BodyBlock::lines), measured once per stage for springs and drive.
struct CentreLines {
  /// @param position_m  column 0 is body block.first
  void measure(const BodyBlock& block, const BlockVectors& position_m) {
    const auto lines = static_cast<Eigen::Index>(block.lines.size());
    if (length_m.size() < lines) {
      length_m.resize(lines);
      direction.resize(3, lines);
    }
    if (lines == 0) return;
    const auto [x, y, z] = components(direction);
    const auto p = components(position_m);
    for (Eigen::Index i = 0; i < lines; ++i) {
      const auto [A, B] = block.lines[i];
      x[i] = p[0][B] - p[0][A];
      y[i] = p[1][B] - p[1][A];
      z[i] = p[2][B] - p[2][A];
    }
    normalise_vectors(block.lines.size(), {x, y, z}, length_m.data());
  }

  Eigen::VectorXd length_m;  ///< 0: the ends coincide, the direction is undefined
  BlockVectors direction;    ///< from the first end to the second
};

/// Adds the forces that pull the ends of a line together.
/// @param e        unit vector from the first end to the second
/// @param force_N  components of the sums
inline void pull_together(const std::array<int, 2>& ends, double tension_N, const std::array<double, 3>& e,
                          const std::array<double*, 3>& force_N) {
  const std::array pull_N{tension_N * e[0], tension_N * e[1], tension_N * e[2]};
  for (std::size_t k = 0; k < 3; ++k) {
    force_N[k][ends[0]] += pull_N[k];
    force_N[k][ends[1]] -= pull_N[k];
  }
}

/// The bodies of one block at one stage of the integrator: all that a force may depend on.
struct Stage {
  const BodyBlock& block;
  const BlockState& state;                         ///< column 0 is body block.first
  const BlockVectors& angular_velocity_rad_per_s;  ///< same columns, world frame
  const CentreLines& lines;                        ///< of the block, measured
  Eigen::Ref<const Eigen::VectorXd> actuation;     ///< value of every actuator of the case [N] or [N m]
};

/// One kind of force between or on bodies. The equations of motion hold a list of them; the order of the list
/// is the order of the sums.
class ForceElement {
 public:
  virtual ~ForceElement() = default;

  /// Adds the forces and the torques about the centres of mass on the bodies of a block, world frame.
  /// @param force_N, torque_N_m  sums to add to, shape (3, ≥ bodies), same columns as the stage
  /// @throws SolverError if a force is not defined in this state
  virtual void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const = 0;
};

/// Gravity less hydrostatic buoyancy of every body,
///   F = (m − ρ V) g                                                                    (B8)
/// The fluid solver computes without gravity, so that its loads are the hydrodynamic part alone.
class Weight final : public ForceElement {
 public:
  explicit Weight(const BodySetup& setup) : force_N_(3, static_cast<Eigen::Index>(setup.bodies.size())) {
    for (Eigen::Index body = 0; body < force_N_.cols(); ++body) {
      const BodySpecification& specification = setup.bodies[body];
      const double displaced_kg = setup.fluid_density_kg_per_m3 * volume_m3(specification.shape);
      force_N_.col(body) = (specification.mass_kg - displaced_kg) * setup.gravity_m_per_s2;
    }
  }

  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors&) const override {
    force_N.leftCols(stage.block.bodies) += force_N_.middleCols(stage.block.first, stage.block.bodies);
  }

 private:
  BlockVectors force_N_;  ///< world frame, shape (3, bodies)
};

}  // namespace copepod::body
