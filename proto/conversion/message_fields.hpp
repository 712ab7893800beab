#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/controller.hpp"
#include "contract/errors.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "conversion/limits.hpp"
#include "conversion/members.hpp"
#include "session/messages.hpp"

namespace copepod::conversion {

// The one description of each message without arrays: `describe` hands each field's name and value to a Writer or a
// Reader, which treat it by its type.

/// A contract struct, constant where it is only read.
template <class T, class Struct>
concept Is = std::same_as<std::remove_const_t<T>, Struct>;

/// Of a text for people, from anywhere: what cannot travel is left out.
inline constexpr struct Prose {
} kProse;

void describe(auto& wire, Is<Shape> auto& shape) {
  COPEPOD_MEMBERS(wire, shape, kind, radius_m, length_m);
  if (shape.kind == ShapeKind::ellipsoid || shape.kind == ShapeKind::box) wire("extents_m", shape.extents_m);
  if (shape.kind == ShapeKind::mesh) wire("mesh", shape.mesh);
  if (shape.kind == ShapeKind::compound) wire("parts", shape.parts);
}

void describe(auto& wire, Is<ShapePart> auto& part) {
  COPEPOD_MEMBERS(wire, part, shape, position_m, orientation_wxyz);
}

void describe(auto& wire, Is<ObstacleSpecification> auto& obstacle) {
  COPEPOD_MEMBERS(wire, obstacle, name, shape, position_m, orientation_wxyz, loads);
}

void describe(auto& wire, Is<Signal::Point> auto& point) { COPEPOD_MEMBERS(wire, point, time_steps, value); }

void describe(auto& wire, Is<Signal> auto& signal) {
  COPEPOD_MEMBERS(wire, signal, kind, amplitude, period_steps, lag_steps, rise, ramp_steps, start_step, stop_step);
  wire("points", signal.table);
}

void describe(auto& wire, Is<Boundary> auto& boundary) {
  COPEPOD_MEMBERS(wire, boundary, kind, velocity_m_per_s, pressure_Pa, parabolic, signal, profile, removes_bodies);
}

void describe(auto& wire, Is<InitialFlow> auto& flow) {
  COPEPOD_MEMBERS(wire, flow, kind, velocity_m_per_s, speed_m_per_s, file, group);
}

void describe(auto& wire, Is<FieldOutput> auto& fields) {
  COPEPOD_MEMBERS(wire, fields, directory, every_steps, mean_start, mean_stop, mean_every_steps, quantities,
                  region_cells, compression);
}

void describe(auto& wire, Is<Probe> auto& probe) { COPEPOD_MEMBERS(wire, probe, name, position_m); }

void describe(auto& wire, Is<FlowSampling> auto& flow) {
  COPEPOD_MEMBERS(wire, flow, every_steps, totals, probes, faces);
}

void describe(auto& wire, Is<BodyPair> auto& pair) {
  wire("body_A", pair.first);
  wire("body_B", pair.second);
}

void describe(auto& wire, Is<FluidSetup> auto& setup) {
  COPEPOD_MEMBERS(wire, setup, kind, step_s, cell_size_m, density_kg_per_m3, kinematic_viscosity_m2_per_s, domain_cells,
                  boundaries);
  wire("no_slip_plane", setup.no_slip_plane, -1);
  COPEPOD_MEMBERS(wire, setup, symmetry_planes, body_force_N_per_m3, initial_flow, collision, moving_boundary, refill,
                  precision, film_thickness_m, wall_overlap_m, bodies, jointed, obstacles, fields, flow,
                  trace_directory);
  wire("parameters", setup.parameters, kLimits.model_bytes);
}

void describe(auto& wire, Is<BodySpecification> auto& body) {
  COPEPOD_MEMBERS(wire, body, name, shape, mass_kg, motion, axis, position_m, orientation_wxyz, velocity_m_per_s,
                  angular_velocity_rad_per_s, inertia_kg_m2);
}

void describe(auto& wire, Is<SpringSpecification> auto& spring) {
  COPEPOD_MEMBERS(wire, spring, body_A, body_B, stiffness_N_per_m, damping_N_s_per_m, rest_length_m, anchor_A_m,
                  anchor_B_m);
}

void describe(auto& wire, Is<BendSpecification> auto& bend) {
  COPEPOD_MEMBERS(wire, bend, body_A, body_B, body_C, stiffness_N_m_per_rad, rest_angle_rad);
}

void describe(auto& wire, Is<JointSpecification> auto& joint) {
  COPEPOD_MEMBERS(wire, joint, kind, body_A);
  wire("body_B", joint.body_B, -1);
  COPEPOD_MEMBERS(wire, joint, anchor_A_m, anchor_B_m, axis, stiffness, damping, rest, lowest, highest);
}

void describe(auto& wire, Is<ActuatorSpecification> auto& actuator) {
  COPEPOD_MEMBERS(wire, actuator, kind, body_A);
  wire("body_B", actuator.body_B, -1);
  COPEPOD_MEMBERS(wire, actuator, direction, anchor_A_m, anchor_B_m);
  wire("joint", actuator.joint, -1);
  wire("control", actuator.control);
}

void describe(auto& wire, Is<WallSpecification> auto& wall) {
  COPEPOD_MEMBERS(wire, wall, point_m, normal, velocity_m_per_s, friction, removes_bodies);
}

void describe(auto& wire, Is<ContactSpecification> auto& contact) {
  COPEPOD_MEMBERS(wire, contact, stiffness_N_per_m, restitution, friction);
}

void describe(auto& wire, Is<ModelSpecification> auto& model) {
  wire("text", model.text, kLimits.model_bytes);
  COPEPOD_MEMBERS(wire, model, length_m, mass_kg, time_s);
}

void describe(auto& wire, Is<BodySetup> auto& setup) {
  COPEPOD_MEMBERS(wire, setup, step_s, integrator, gravity_m_per_s2, fluid_density_kg_per_m3, periodic_length_m, bodies,
                  springs, bends, joints, actuators, walls, contact, model);
  wire("threads", setup.threads, 1);
  wire("trace_directory", setup.trace_directory);
  wire("parameters", setup.parameters, kLimits.model_bytes);
}

void describe(auto& wire, Is<ControllerSetup> auto& setup) {
  COPEPOD_MEMBERS(wire, setup, name, step_s, every_steps, bodies, actuators, trace_directory, flow);
  wire("parameters", setup.parameters, kLimits.model_bytes);
}

void describe(auto& wire, Is<session::VersionRange> auto& versions) {
  COPEPOD_MEMBERS(wire, versions, major, minor_min, minor_max);
}

void describe(auto& wire, Is<Capabilities> auto& capabilities) {
  COPEPOD_MEMBERS(wire, capabilities, name, version, features);
}

void describe(auto& wire, Is<session::Hello> auto& hello) {
  COPEPOD_MEMBERS(wire, hello, role, lane, versions, session_token, capabilities, host, pid, ranks, instance, name);
}

void describe(auto& wire, Is<session::Welcome> auto& welcome) {
  COPEPOD_MEMBERS(wire, welcome, minor, session_id, epoch);
}

void describe(auto& wire, Is<session::Refusal> auto& refusal) { wire("reason", refusal.reason, kProse); }

void describe(auto& wire, Is<session::CheckpointPath> auto& path) { wire("path", path.path); }

void describe(auto& wire, Is<session::Saved> auto& saved) { wire("problem", saved.problem, kProse); }

void describe(auto& wire, Is<SolverSummary> auto& summary) {
  COPEPOD_MEMBERS(wire, summary, digest, cell_updates, ranks, body_phases, waiting_phases, mass_drift, momentum_drift);
}

void describe(auto& wire, Is<session::Ping> auto& ping) { wire("stamp_ns", ping.stamp_ns); }

void describe(auto& wire, Is<session::Pong> auto& pong) {
  COPEPOD_MEMBERS(wire, pong, stamp_ns, step, phase, progress, received_sequence, replied_sequence, awaited_rank);
}

void describe(auto& wire, Is<FailureReport> auto& failure) {
  wire("code", failure.code);
  wire("component", failure.component, kProse);
  wire("host", failure.host, kProse);
  COPEPOD_MEMBERS(wire, failure, rank, step);
  wire("reason", failure.reason, kProse);
}

// What the fields of a message must fulfil together.

void check(const auto& /*other messages*/) {}

inline void check(const Shape& shape) {
  const bool has_extents = shape.kind == ShapeKind::ellipsoid || shape.kind == ShapeKind::box;
  if (!(shape.radius_m > 0.0) || shape.length_m < 0.0 || (has_extents && !(shape.extents_m.minCoeff() > 0.0)))
    throw MalformedMessage("a shape has an extent that is not positive");
  if (shape.kind == ShapeKind::compound && shape.parts.empty()) throw MalformedMessage("a compound has no parts");
}

inline void check(const ShapePart& part) {
  if (part.shape.kind == ShapeKind::compound) throw MalformedMessage("a part of a compound is a compound itself");
}

inline void check(const BodySpecification& body) {
  if (!body.inertia_kg_m2.empty() && body.inertia_kg_m2.size() != 6)
    throw MalformedMessage("inertia_kg_m2 has " + std::to_string(body.inertia_kg_m2.size()) + " entries, not 6");
}

inline void check(const Signal& signal) {
  const auto ascends = [](const Signal::Point& a, const Signal::Point& b) { return a.time_steps < b.time_steps; };
  const bool repeats = signal.kind != SignalKind::constant && signal.kind != SignalKind::table;
  if ((repeats && signal.period_steps == 0) || (signal.kind == SignalKind::table) == signal.table.empty() ||
      (signal.kind == SignalKind::trapezoid) != (signal.rise > 0.0 && signal.rise <= 0.25) ||
      std::ranges::adjacent_find(signal.table, std::not_fn(ascends)) != signal.table.end())
    throw MalformedMessage("a signal lacks its period, rise or points, or has some that are not its own");
}

inline void check(const FieldOutput& fields) {
  const std::vector<std::int64_t>& region = fields.region_cells;
  if (!region.empty() && region.size() != 6)
    throw MalformedMessage("fields.region_cells has " + std::to_string(region.size()) + " entries, not 6");
  for (std::size_t i = 0; i < region.size(); i += 2)
    if (region[i + 1] > 0 ? region[i] >= region[i + 1] : region[i] > 0)
      throw MalformedMessage("fields.region_cells has no cells along an axis");
  if (fields.compression > 9)
    throw MalformedMessage("fields.compression is " + std::to_string(fields.compression) + ", more than 9");
  if (fields.mean_stop == 0) return;
  if (fields.mean_start >= fields.mean_stop)
    throw MalformedMessage("fields.mean_start is " + std::to_string(fields.mean_start) + ", not before mean_stop " +
                           std::to_string(fields.mean_stop));
  if (fields.mean_every_steps == 0) throw MalformedMessage("fields.mean_every_steps of a mean is 0");
}

inline void check(const FlowSampling& flow) {
  for (const std::int64_t face : flow.faces)
    if (face > 5) throw MalformedMessage("flow.faces has face " + std::to_string(face) + ", a domain has faces 0 to 5");
}

inline void check(const FluidSetup& setup) {
  double cells = 1.0;
  for (const std::int64_t along : setup.domain_cells) cells *= std::max(1.0, static_cast<double>(along));
  if (cells > kLimits.cells) throw MalformedMessage("domain_cells are more than 10^12 cells");
  if (setup.no_slip_plane > 5)
    throw MalformedMessage("no_slip_plane is face " + std::to_string(setup.no_slip_plane) +
                           ", a domain has faces 0 to 5");
  for (const auto& [A, B] : setup.jointed)
    if (A >= B || static_cast<std::size_t>(B) >= setup.bodies.size())
      throw MalformedMessage("a joint joins bodies " + std::to_string(A) + " and " + std::to_string(B) + " of " +
                             std::to_string(setup.bodies.size()));
}

inline void check(const ControllerSetup& setup) {
  if (setup.every_steps < 1) throw MalformedMessage("every_steps of a controller is 0");
}

inline void check(const BodySetup& setup) {
  const auto require = [&](const std::string& what, std::initializer_list<int> bodies) {
    std::string numbers;
    for (const int body : bodies) numbers += (numbers.empty() ? "" : " and ") + std::to_string(body);
    for (const int body : bodies)
      if (static_cast<std::size_t>(body) >= setup.bodies.size())
        throw MalformedMessage(what + " bodies " + numbers + " of " + std::to_string(setup.bodies.size()));
  };
  for (const SpringSpecification& spring : setup.springs) require("a spring joins", {spring.body_A, spring.body_B});
  for (const BendSpecification& bend : setup.bends) require("a bend joins", {bend.body_A, bend.body_B, bend.body_C});
  for (const JointSpecification& joint : setup.joints) {
    require("a joint joins", {joint.body_A});
    if (joint.body_B >= 0) require("a joint joins", {joint.body_A, joint.body_B});
  }
  for (const ActuatorSpecification& actuator : setup.actuators) {
    require("an actuator is on", {actuator.body_A});
    if (actuator.kind == ActuatorKind::pair_force) require("a pair force joins", {actuator.body_A, actuator.body_B});
    if (actuator.kind == ActuatorKind::joint_motion && static_cast<std::size_t>(actuator.joint) >= setup.joints.size())
      throw MalformedMessage("an actuator drives joint " + std::to_string(actuator.joint) + " of " +
                             std::to_string(setup.joints.size()));
  }
}

}  // namespace copepod::conversion
