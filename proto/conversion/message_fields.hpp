#pragma once

#include <algorithm>
#include <concepts>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/errors.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"
#include "conversion/limits.hpp"
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
  wire("kind", shape.kind);
  wire("radius_m", shape.radius_m);
  wire("length_m", shape.length_m);
  if (shape.kind == ShapeKind::ellipsoid || shape.kind == ShapeKind::box) wire("extents_m", shape.extents_m);
  if (shape.kind == ShapeKind::mesh) wire("mesh", shape.mesh);
  if (shape.kind == ShapeKind::compound) wire("parts", shape.parts);
}

void describe(auto& wire, Is<ShapePart> auto& part) {
  wire("shape", part.shape);
  wire("position_m", part.position_m);
  wire("orientation_wxyz", part.orientation_wxyz);
}

void describe(auto& wire, Is<ObstacleSpecification> auto& obstacle) {
  wire("name", obstacle.name);
  wire("shape", obstacle.shape);
  wire("position_m", obstacle.position_m);
  wire("orientation_wxyz", obstacle.orientation_wxyz);
  wire("loads", obstacle.loads);
}

void describe(auto& wire, Is<Boundary> auto& boundary) {
  wire("kind", boundary.kind);
  wire("velocity_m_per_s", boundary.velocity_m_per_s);
  wire("pressure_Pa", boundary.pressure_Pa);
  wire("parabolic", boundary.parabolic);
}

void describe(auto& wire, Is<InitialFlow> auto& flow) {
  wire("kind", flow.kind);
  wire("velocity_m_per_s", flow.velocity_m_per_s);
  wire("speed_m_per_s", flow.speed_m_per_s);
}

void describe(auto& wire, Is<FieldOutput> auto& fields) {
  wire("directory", fields.directory);
  wire("every_steps", fields.every_steps);
  wire("mean_start", fields.mean_start);
  wire("mean_stop", fields.mean_stop);
  wire("mean_every_steps", fields.mean_every_steps);
  wire("quantities", fields.quantities);
  wire("region_cells", fields.region_cells);
  wire("compression", fields.compression);
}

void describe(auto& wire, Is<BodyPair> auto& pair) {
  wire("body_A", pair.first);
  wire("body_B", pair.second);
}

void describe(auto& wire, Is<FluidSetup> auto& setup) {
  wire("kind", setup.kind);
  wire("step_s", setup.step_s);
  wire("cell_size_m", setup.cell_size_m);
  wire("density_kg_per_m3", setup.density_kg_per_m3);
  wire("kinematic_viscosity_m2_per_s", setup.kinematic_viscosity_m2_per_s);
  wire("domain_cells", setup.domain_cells);
  wire("boundaries", setup.boundaries);
  wire("no_slip_plane", setup.no_slip_plane, -1);
  wire("symmetry_planes", setup.symmetry_planes);
  wire("body_force_N_per_m3", setup.body_force_N_per_m3);
  wire("initial_flow", setup.initial_flow);
  wire("collision", setup.collision);
  wire("moving_boundary", setup.moving_boundary);
  wire("refill", setup.refill);
  wire("precision", setup.precision);
  wire("film_thickness_m", setup.film_thickness_m);
  wire("wall_overlap_m", setup.wall_overlap_m);
  wire("bodies", setup.bodies);
  wire("jointed", setup.jointed);
  wire("obstacles", setup.obstacles);
  wire("fields", setup.fields);
  wire("trace_directory", setup.trace_directory);
}

void describe(auto& wire, Is<BodySpecification> auto& body) {
  wire("name", body.name);
  wire("shape", body.shape);
  wire("mass_kg", body.mass_kg);
  wire("motion", body.motion);
  wire("axis", body.axis);
  wire("position_m", body.position_m);
  wire("orientation_wxyz", body.orientation_wxyz);
  wire("velocity_m_per_s", body.velocity_m_per_s);
  wire("angular_velocity_rad_per_s", body.angular_velocity_rad_per_s);
  wire("inertia_kg_m2", body.inertia_kg_m2);
}

void describe(auto& wire, Is<SpringSpecification> auto& spring) {
  wire("body_A", spring.body_A);
  wire("body_B", spring.body_B);
  wire("stiffness_N_per_m", spring.stiffness_N_per_m);
  wire("damping_N_s_per_m", spring.damping_N_s_per_m);
  wire("rest_length_m", spring.rest_length_m);
  wire("anchor_A_m", spring.anchor_A_m);
  wire("anchor_B_m", spring.anchor_B_m);
}

void describe(auto& wire, Is<BendSpecification> auto& bend) {
  wire("body_A", bend.body_A);
  wire("body_B", bend.body_B);
  wire("body_C", bend.body_C);
  wire("stiffness_N_m_per_rad", bend.stiffness_N_m_per_rad);
  wire("rest_angle_rad", bend.rest_angle_rad);
}

void describe(auto& wire, Is<JointSpecification> auto& joint) {
  wire("kind", joint.kind);
  wire("body_A", joint.body_A);
  wire("body_B", joint.body_B, -1);
  wire("anchor_A_m", joint.anchor_A_m);
  wire("anchor_B_m", joint.anchor_B_m);
  wire("axis", joint.axis);
  wire("stiffness", joint.stiffness);
  wire("damping", joint.damping);
  wire("rest", joint.rest);
  wire("lowest", joint.lowest);
  wire("highest", joint.highest);
}

void describe(auto& wire, Is<ActuatorSpecification> auto& actuator) {
  wire("kind", actuator.kind);
  wire("body_A", actuator.body_A);
  wire("body_B", actuator.body_B, -1);
  wire("direction", actuator.direction);
  wire("anchor_A_m", actuator.anchor_A_m);
  wire("anchor_B_m", actuator.anchor_B_m);
  wire("joint", actuator.joint, -1);
  wire("control", actuator.control);
}

void describe(auto& wire, Is<WallSpecification> auto& wall) {
  wire("point_m", wall.point_m);
  wire("normal", wall.normal);
  wire("velocity_m_per_s", wall.velocity_m_per_s);
  wire("friction", wall.friction);
}

void describe(auto& wire, Is<ContactSpecification> auto& contact) {
  wire("stiffness_N_per_m", contact.stiffness_N_per_m);
  wire("restitution", contact.restitution);
  wire("friction", contact.friction);
}

void describe(auto& wire, Is<ModelSpecification> auto& model) {
  wire("text", model.text, kLimits.model_bytes);
  wire("length_m", model.length_m);
  wire("mass_kg", model.mass_kg);
  wire("time_s", model.time_s);
}

void describe(auto& wire, Is<BodySetup> auto& setup) {
  wire("step_s", setup.step_s);
  wire("integrator", setup.integrator);
  wire("gravity_m_per_s2", setup.gravity_m_per_s2);
  wire("fluid_density_kg_per_m3", setup.fluid_density_kg_per_m3);
  wire("periodic_length_m", setup.periodic_length_m);
  wire("bodies", setup.bodies);
  wire("springs", setup.springs);
  wire("bends", setup.bends);
  wire("joints", setup.joints);
  wire("actuators", setup.actuators);
  wire("walls", setup.walls);
  wire("contact", setup.contact);
  wire("model", setup.model);
  wire("threads", setup.threads, 1);
  wire("trace_directory", setup.trace_directory);
}

void describe(auto& wire, Is<session::VersionRange> auto& versions) {
  wire("major", versions.major);
  wire("minor_min", versions.minor_min);
  wire("minor_max", versions.minor_max);
}

void describe(auto& wire, Is<Capabilities> auto& capabilities) {
  wire("name", capabilities.name);
  wire("version", capabilities.version);
  wire("features", capabilities.features);
}

void describe(auto& wire, Is<session::Hello> auto& hello) {
  wire("role", hello.role);
  wire("lane", hello.lane);
  wire("versions", hello.versions);
  wire("session_token", hello.session_token);
  wire("capabilities", hello.capabilities);
  wire("host", hello.host);
  wire("pid", hello.pid);
  wire("ranks", hello.ranks);
  wire("instance", hello.instance);
}

void describe(auto& wire, Is<session::Welcome> auto& welcome) {
  wire("minor", welcome.minor);
  wire("session_id", welcome.session_id);
  wire("epoch", welcome.epoch);
}

void describe(auto& wire, Is<session::Refusal> auto& refusal) { wire("reason", refusal.reason, kProse); }

void describe(auto& wire, Is<session::CheckpointPath> auto& path) { wire("path", path.path); }

void describe(auto& wire, Is<session::Saved> auto& saved) { wire("problem", saved.problem, kProse); }

void describe(auto& wire, Is<SolverSummary> auto& summary) {
  wire("digest", summary.digest);
  wire("cell_updates", summary.cell_updates);
  wire("ranks", summary.ranks);
  wire("body_phases", summary.body_phases);
  wire("waiting_phases", summary.waiting_phases);
  wire("mass_drift", summary.mass_drift);
  wire("momentum_drift", summary.momentum_drift);
}

void describe(auto& wire, Is<session::Ping> auto& ping) { wire("stamp_ns", ping.stamp_ns); }

void describe(auto& wire, Is<session::Pong> auto& pong) {
  wire("stamp_ns", pong.stamp_ns);
  wire("step", pong.step);
  wire("phase", pong.phase);
  wire("progress", pong.progress);
  wire("received_sequence", pong.received_sequence);
  wire("replied_sequence", pong.replied_sequence);
  wire("awaited_rank", pong.awaited_rank);
}

void describe(auto& wire, Is<FailureReport> auto& failure) {
  wire("code", failure.code);
  wire("component", failure.component, kProse);
  wire("host", failure.host, kProse);
  wire("rank", failure.rank);
  wire("step", failure.step);
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

inline void check(const FieldOutput& fields) {
  const std::vector<std::int64_t>& region = fields.region_cells;
  if (!region.empty() && region.size() != 6)
    throw MalformedMessage("fields.region_cells has " + std::to_string(region.size()) + " entries, not 6");
  for (std::size_t i = 0; i < region.size(); i += 2) {
    if (region[i + 1] > 0 ? region[i] >= region[i + 1] : region[i] > 0)
      throw MalformedMessage("fields.region_cells has no cells along an axis");
  }
  if (fields.compression > 9)
    throw MalformedMessage("fields.compression is " + std::to_string(fields.compression) + ", more than 9");
  if (fields.mean_stop == 0) return;
  if (fields.mean_start >= fields.mean_stop) {
    throw MalformedMessage("fields.mean_start is " + std::to_string(fields.mean_start) + ", not before mean_stop " +
                           std::to_string(fields.mean_stop));
  }
  if (fields.mean_every_steps == 0) throw MalformedMessage("fields.mean_every_steps of a mean is 0");
}

inline void check(const FluidSetup& setup) {
  double cells = 1.0;
  for (const std::int64_t along : setup.domain_cells) cells *= std::max(1.0, static_cast<double>(along));
  if (cells > kLimits.cells) throw MalformedMessage("domain_cells are more than 10^12 cells");
  if (setup.no_slip_plane > 5) {
    throw MalformedMessage("no_slip_plane is face " + std::to_string(setup.no_slip_plane) +
                           ", a domain has faces 0 to 5");
  }
  for (const auto& [A, B] : setup.jointed) {
    if (A >= B || static_cast<std::size_t>(B) >= setup.bodies.size())
      throw MalformedMessage("a joint joins bodies " + std::to_string(A) + " and " + std::to_string(B) + " of " +
                             std::to_string(setup.bodies.size()));
  }
}

inline void check(const BodySetup& setup) {
  const auto require = [&](const std::string& what, std::initializer_list<int> bodies) {
    std::string numbers;
    for (const int body : bodies) numbers += (numbers.empty() ? "" : " and ") + std::to_string(body);
    for (const int body : bodies) {
      if (static_cast<std::size_t>(body) >= setup.bodies.size())
        throw MalformedMessage(what + " bodies " + numbers + " of " + std::to_string(setup.bodies.size()));
    }
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
