#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

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

/// Force with which a spring and damper pull their ends together [N]: k (|d| − l₀) + γ ḋ·e of (B6)
/// @param e                  unit vector along it, world frame
/// @param ddot_AB_W_m_per_s  velocity of end B less that of end A, world frame [m/s]
template <class Vector>
double tension_N(const SpringSpecification& spring, double length_m, const Vector& e, const Vector& ddot_AB_W_m_per_s) {
  const Vector& u = ddot_AB_W_m_per_s;
  return spring.stiffness_N_per_m * (length_m - spring.rest_length_m) +
         spring.damping_N_s_per_m * (u[0] * e[0] + u[1] * e[1] + u[2] * e[2]);
}

/// Force of a spring and damper on its end A, along the line between its ends:
///   F_A = (k (|d| − l₀) + γ ḋ·e) e,   d = A to B, e = d/|d|             [paper, eqs. (5), (6)]     (B6)
/// The paper's swimmers move on a line, where its vectors Δx and Δu have this one component. Off a line the
/// damping, too, acts along the spring only: a damper across it would brake rigid rotations and create
/// angular momentum.
/// @param d_AB_W_m          from end A to end B, world frame [m]
/// @param ddot_AB_W_m_per_s  its rate of change [m/s]
/// @return force on A, world frame [N]; B receives the negative. NaN if the ends coincide (no direction).
inline Eigen::Vector3d spring_force(const SpringSpecification& spring, const Eigen::Vector3d& d_AB_W_m,
                                    const Eigen::Vector3d& ddot_AB_W_m_per_s) {
  const Eigen::Vector3d& d = d_AB_W_m;
  const double length_m = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const Eigen::Vector3d e = d / length_m;
  return tension_N(spring, length_m, e, ddot_AB_W_m_per_s) * e;
}

/// All springs of a case.
class Springs final : public ForceElement {
 public:
  /// Force of one spring, and where it acts; world frame.
  struct Pull {
    Eigen::Vector3d r_A_W_m;   ///< from A's centre of mass to its anchor
    Eigen::Vector3d r_B_W_m;   ///< from B's centre of mass to its anchor
    Eigen::Vector3d d_AB_W_m;  ///< from A's anchor to B's
    Eigen::Vector3d f_A_W_N;   ///< on A; B receives the negative
  };

  /// @throws CaseError if a spring connects bodies that do not exist, or a body to itself, or has a negative
  ///         stiffness, damping or rest length
  explicit Springs(const BodySetup& setup);

  /// Adds the springs' loads spring by spring, in the order of the setup.
  /// @throws SolverError naming both bodies if the ends of a spring coincide
  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const override;

  /// Pull of spring number `index`:
  ///   d = (p_B + r_B) − (p_A + r_A),   ḋ = (v_B + ω_B × r_B) − (v_A + ω_A × r_A),   r = R anchor    (B7)
  ///   force ±F of (B6) at the anchors, torque r × F about the centre of mass
  /// @param first  body of column 0 of `state` and `w_WB_rad_per_s`
  /// @throws SolverError naming both bodies if the anchors coincide
  [[nodiscard]] Pull pull(std::size_t index, Eigen::Index first, const BlockState& state,
                          const BlockVectors& w_WB_rad_per_s) const;

 private:
  void add_anchored(std::size_t index, const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const;
  [[noreturn]] void fail(const SpringSpecification& spring) const;

  std::vector<SpringSpecification> springs_;
  std::vector<std::string> names_;  ///< of the bodies, for errors
};

/// All bends of a case: angular springs that keep the angle θ at body B between its arms a = p_A − p_B and
/// c = p_C − p_B near the rest angle,
///   E = κ (θ − θ₀)²/2,   F_A = κ (θ − θ₀) t_a/|a|,   F_C = κ (θ − θ₀) t_c/|c|,   F_B = −F_A − F_C          (B19)
/// with the unit vectors t_a and t_c across the arms, in their plane, towards the other arm.
class Bends final : public ForceElement {
 public:
  /// @throws CaseError if a bend joins bodies that do not exist or are not three, has a negative stiffness, or a rest
  ///         angle outside [0, π]
  explicit Bends(const BodySetup& setup);

  /// @throws SolverError naming the bodies if two of them coincide, or if their arms are parallel and the rest angle
  ///         is another one (the forces have no direction)
  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const override;

 private:
  [[noreturn]] void fail(const BendSpecification& bend) const;

  std::vector<BendSpecification> bends_;
  std::vector<std::string> names_;  ///< of the bodies, for errors
};

/// The drive: all actuators of a case, along their current directions.
class Actuators final : public ForceElement {
 public:
  /// @throws CaseError if an actuator is on bodies that do not exist, or a pair on one body, or a direction is not a
  ///         unit vector
  explicit Actuators(const BodySetup& setup);

  /// Adds the loads actuator by actuator, in the order of the setup.
  /// @throws SolverError if the ends of a pair coincide
  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const override;

 private:
  std::vector<ActuatorSpecification> actuators_;
};

}  // namespace copepod::body
