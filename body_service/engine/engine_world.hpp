#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/errors.hpp"
#include "contract/exchange.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"

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

/// The bodies of a case in the library of a rigid-body engine, which moves them, resolves their contacts and keeps
/// their joints.
class EngineWorld {
 public:
  virtual ~EngineWorld() = default;

  /// Whether `advance` adds the forces of the springs itself, so that the loads are without them.
  [[nodiscard]] virtual bool has_springs() const { return false; }

  /// As BodySolver::driving_nodes. Forces are constant over a step, of the values at its start.
  [[nodiscard]] virtual std::vector<double> driving_nodes() const { return {0.0}; }
  /// Before each `advance`, for an engine with two driving nodes: the actuators' values at the end of that step.
  virtual void drive(const Eigen::VectorXd& /*values*/) {}

  /// One step of the length that the world was made for, under constant loads.
  /// @param state  SI units, world frame; in and out
  /// @param loads  forces and torques about the centres, finite
  /// @throws SolverError if the engine gives up
  virtual void advance(Kinematics& state, const Loads& loads) = 0;

  /// What the engine carries from step to step beside the kinematics of the bodies.
  [[nodiscard]] virtual std::vector<std::uint64_t> memory() const { return {}; }
  /// @param memory  as memory() gave it, for the same setup
  virtual void restore(std::span<const std::uint64_t> /*memory*/) {}
};

/// @param model  outlives the world
/// @param step_s  of `advance`
using MakeEngineWorld =
    std::function<std::unique_ptr<EngineWorld>(const BodySetup& setup, const BodyModel& model, double step_s)>;

/// Kinematics in the form in which states are stored, digested and passed to force elements; the last columns hold
/// angular velocities.
template <class State = MotionState>
State as_motion_state(const Kinematics& state) {
  return {state.position_m, state.orientation_wxyz, state.velocity_m_per_s, state.angular_velocity_rad_per_s};
}

/// Of the start of a case.
inline Kinematics initial_kinematics(const BodyModel& model) {
  const MotionState& start = model.initial_state();
  Kinematics state{0, start.position_m, start.orientation_wxyz, start.velocity_m_per_s,
                   Eigen::Matrix3Xd(3, model.bodies())};
  for (Eigen::Index body = 0; body < model.bodies(); ++body)
    state.angular_velocity_rad_per_s.col(body) = model.angular_velocity_rad_per_s(body, start);
  return state;
}

inline bool is_resolving(const ContactSpecification& contact) { return contact.stiffness_N_per_m > 0.0; }

/// @throws CaseError if it moves
inline void require_at_rest(const WallSpecification& wall) {
  if (wall.velocity_m_per_s.isZero(0.0)) return;
  throw CaseError("a wall moves (walls of engines are at rest). Use boundaries at rest, or body.solver: own.");
}

/// The sign that is nearer to the quaternion before; both are the same rotation.
inline Eigen::Vector4d of_the_same_sign(const Eigen::Vector4d& q, const Eigen::Vector4d& before) {
  return q.dot(before) < 0.0 ? Eigen::Vector4d(-q) : q;
}

}  // namespace copepod::body
