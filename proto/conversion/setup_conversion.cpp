#include "conversion/setup_conversion.hpp"

#include <algorithm>

#include "conversion/arrays.hpp"
#include "conversion/enumerations.hpp"
#include "conversion/limits.hpp"

namespace copepod::conversion {

namespace {

void write_shape(const Shape& shape, v1::Shape& wire) {
  wire.set_kind(to_wire<v1::ShapeKind>(shape.kind));
  wire.set_radius_m(shape.radius_m);
  wire.set_length_m(shape.length_m);
}

Shape read_shape(const v1::Shape& wire) {
  return {from_wire(wire.kind(), ShapeKind::capsule, "shape kind"), read_finite(wire.radius_m(), "radius_m"),
          read_finite(wire.length_m(), "length_m")};
}

void write_boundary(const Boundary& boundary, v1::Boundary& wire) {
  wire.set_kind(to_wire<v1::BoundaryKind>(boundary.kind));
  assign(*wire.mutable_velocity_m_per_s(), boundary.velocity_m_per_s);
  wire.set_pressure_pa(boundary.pressure_Pa);
}

Boundary read_boundary(const v1::Boundary& wire) {
  return {from_wire(wire.kind(), BoundaryKind::pressure, "boundary kind"),
          read_vector<Eigen::Vector3d>(wire.velocity_m_per_s(), "boundary velocity_m_per_s"),
          read_finite(wire.pressure_pa(), "pressure_Pa")};
}

void write_fields(const FieldOutput& fields, v1::FieldOutput& wire) {
  wire.set_directory(fields.directory);
  wire.set_every_steps(fields.every_steps);
  wire.set_mean_start(fields.mean_start);
  wire.set_mean_stop(fields.mean_stop);
  wire.set_mean_every_steps(fields.mean_every_steps);
}

const std::string& read_path(const std::string& path, const char* name) {
  require_at_most(path.size(), kLimits.string_bytes, name);
  return path;
}

std::int64_t read_count(std::int64_t count, const char* name) {
  if (count < 0) throw MalformedMessage(std::string(name) + " is " + std::to_string(count) + ", less than 0");
  return count;
}

/// @throws MalformedMessage too if a mean is wanted of no step
FieldOutput read_fields(const v1::FieldOutput& wire) {
  const FieldOutput fields{
      read_path(wire.directory(), "fields.directory"), read_count(wire.every_steps(), "fields.every_steps"),
      read_count(wire.mean_start(), "fields.mean_start"), read_count(wire.mean_stop(), "fields.mean_stop"),
      read_count(wire.mean_every_steps(), "fields.mean_every_steps")};
  if (fields.mean_stop == 0) return fields;
  if (fields.mean_start >= fields.mean_stop) {
    throw MalformedMessage("fields.mean_start is " + std::to_string(fields.mean_start) +
                           ", not before mean_stop " + std::to_string(fields.mean_stop));
  }
  if (fields.mean_every_steps == 0) throw MalformedMessage("fields.mean_every_steps of a mean is 0");
  return fields;
}

/// @throws MalformedMessage too if their number is beyond counting
std::array<std::int64_t, 3> read_cells(const v1::FluidSetup& wire) {
  std::array<std::int64_t, 3> cells{};
  double product = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    cells[static_cast<std::size_t>(axis)] = read_count(wire.domain_cells(axis), "domain_cells");
    product *= std::max(1.0, static_cast<double>(wire.domain_cells(axis)));
  }
  if (product > kLimits.cells) throw MalformedMessage("domain_cells are more than 10^12 cells");
  return cells;
}

void require_three(int size, const char* name) {
  if (size != 3)
    throw MalformedMessage(std::string(name) + " has " + std::to_string(size) + " entries, not 3");
}

void write_body(const BodySpecification& body, v1::BodySpecification& wire) {
  wire.set_name(body.name);
  write_shape(body.shape, *wire.mutable_shape());
  wire.set_mass_kg(body.mass_kg);
  wire.set_motion(to_wire<v1::MotionKind>(body.motion));
  assign(*wire.mutable_axis(), body.axis);
  assign(*wire.mutable_position_m(), body.position_m);
  assign(*wire.mutable_orientation_wxyz(), body.orientation_wxyz);
  assign(*wire.mutable_velocity_m_per_s(), body.velocity_m_per_s);
  assign(*wire.mutable_angular_velocity_rad_per_s(), body.angular_velocity_rad_per_s);
}

BodySpecification read_body(const v1::BodySpecification& wire) {
  require_at_most(wire.name().size(), kLimits.string_bytes, "body name");
  BodySpecification body;
  body.name = wire.name();
  body.shape = read_shape(wire.shape());
  body.mass_kg = read_finite(wire.mass_kg(), "mass_kg");
  body.motion = from_wire(wire.motion(), MotionKind::axis, "motion kind");
  body.axis = read_vector<Eigen::Vector3d>(wire.axis(), "axis");
  body.position_m = read_vector<Eigen::Vector3d>(wire.position_m(), "position_m");
  body.orientation_wxyz = read_vector<Eigen::Vector4d>(wire.orientation_wxyz(), "orientation_wxyz");
  body.velocity_m_per_s = read_vector<Eigen::Vector3d>(wire.velocity_m_per_s(), "velocity_m_per_s");
  body.angular_velocity_rad_per_s =
      read_vector<Eigen::Vector3d>(wire.angular_velocity_rad_per_s(), "angular_velocity_rad_per_s");
  return body;
}

void write_spring(const SpringSpecification& spring, v1::SpringSpecification& wire) {
  wire.set_body_a(static_cast<std::uint32_t>(spring.body_A));
  wire.set_body_b(static_cast<std::uint32_t>(spring.body_B));
  wire.set_stiffness_n_per_m(spring.stiffness_N_per_m);
  wire.set_damping_n_s_per_m(spring.damping_N_s_per_m);
  wire.set_rest_length_m(spring.rest_length_m);
  assign(*wire.mutable_anchor_a_m(), spring.anchor_A_m);
  assign(*wire.mutable_anchor_b_m(), spring.anchor_B_m);
}

SpringSpecification read_spring(const v1::SpringSpecification& wire, std::size_t bodies) {
  if (wire.body_a() >= bodies || wire.body_b() >= bodies) {
    throw MalformedMessage("a spring joins bodies " + std::to_string(wire.body_a()) + " and " +
                           std::to_string(wire.body_b()) + " of " + std::to_string(bodies));
  }
  SpringSpecification spring;
  spring.body_A = static_cast<int>(wire.body_a());
  spring.body_B = static_cast<int>(wire.body_b());
  spring.stiffness_N_per_m = read_finite(wire.stiffness_n_per_m(), "stiffness_N_per_m");
  spring.damping_N_s_per_m = read_finite(wire.damping_n_s_per_m(), "damping_N_s_per_m");
  spring.rest_length_m = read_finite(wire.rest_length_m(), "rest_length_m");
  spring.anchor_A_m = read_vector<Eigen::Vector3d>(wire.anchor_a_m(), "anchor_A_m");
  spring.anchor_B_m = read_vector<Eigen::Vector3d>(wire.anchor_b_m(), "anchor_B_m");
  return spring;
}

}  // namespace

void write(const FluidSetup& setup, v1::FluidSetup& wire) {
  wire.Clear();
  wire.set_kind(to_wire<v1::FluidKind>(setup.kind));
  wire.set_step_s(setup.step_s);
  wire.set_cell_size_m(setup.cell_size_m);
  wire.set_density_kg_per_m3(setup.density_kg_per_m3);
  wire.set_kinematic_viscosity_m2_per_s(setup.kinematic_viscosity_m2_per_s);
  for (const std::int64_t cells : setup.domain_cells) wire.add_domain_cells(cells);
  for (const Boundary& boundary : setup.boundaries) write_boundary(boundary, *wire.add_boundaries());
  wire.set_no_slip_plane(static_cast<std::uint32_t>(1 + setup.no_slip_plane));
  for (const bool mirrored : setup.symmetry_planes) wire.add_symmetry_planes(mirrored);
  assign(*wire.mutable_body_force_n_per_m3(), setup.body_force_N_per_m3);
  wire.set_collision(to_wire<v1::CollisionKind>(setup.collision));
  wire.set_moving_boundary(to_wire<v1::MovingBoundary>(setup.moving_boundary));
  wire.set_refill(to_wire<v1::Refill>(setup.refill));
  wire.set_precision(to_wire<v1::Precision>(setup.precision));
  for (const Shape& shape : setup.bodies) write_shape(shape, *wire.add_bodies());
  write_fields(setup.fields, *wire.mutable_fields());
  wire.set_trace_directory(setup.trace_directory);
}

void read(const v1::FluidSetup& wire, FluidSetup& setup) {
  require_three(wire.domain_cells_size(), "domain_cells");
  require_three(wire.symmetry_planes_size(), "symmetry_planes");
  if (wire.boundaries_size() != 6) {
    throw MalformedMessage("boundaries has " + std::to_string(wire.boundaries_size()) + " entries, not 6");
  }
  require_at_most(static_cast<std::size_t>(wire.bodies_size()), kLimits.bodies, "bodies");
  setup.kind = from_wire(wire.kind(), FluidKind::vacuum, "fluid kind");
  setup.step_s = read_finite(wire.step_s(), "step_s");
  setup.cell_size_m = read_finite(wire.cell_size_m(), "cell_size_m");
  setup.density_kg_per_m3 = read_finite(wire.density_kg_per_m3(), "density_kg_per_m3");
  setup.kinematic_viscosity_m2_per_s =
      read_finite(wire.kinematic_viscosity_m2_per_s(), "kinematic_viscosity_m2_per_s");
  setup.domain_cells = read_cells(wire);
  for (int axis = 0; axis < 3; ++axis) {
    setup.symmetry_planes[static_cast<std::size_t>(axis)] = wire.symmetry_planes(axis);
  }
  for (int face = 0; face < 6; ++face) {
    setup.boundaries[static_cast<std::size_t>(face)] = read_boundary(wire.boundaries(face));
  }
  if (wire.no_slip_plane() > 6) {
    throw MalformedMessage("no_slip_plane is " + std::to_string(wire.no_slip_plane()) +
                           ", a domain has 6 faces");
  }
  setup.no_slip_plane = static_cast<int>(wire.no_slip_plane()) - 1;
  setup.body_force_N_per_m3 = read_vector<Eigen::Vector3d>(wire.body_force_n_per_m3(), "body_force_N_per_m3");
  setup.collision = from_wire(wire.collision(), CollisionKind::trt, "collision kind");
  setup.moving_boundary = from_wire(wire.moving_boundary(), MovingBoundary::bounce_back, "moving_boundary");
  setup.refill = from_wire(wire.refill(), Refill::equilibrium, "refill");
  setup.precision = from_wire(wire.precision(), Precision::single_precision, "precision");
  setup.bodies.clear();
  for (const v1::Shape& shape : wire.bodies()) setup.bodies.push_back(read_shape(shape));
  setup.fields = read_fields(wire.fields());
  setup.trace_directory = read_path(wire.trace_directory(), "trace_directory");
}

void write(const BodySetup& setup, v1::BodySetup& wire) {
  wire.Clear();
  wire.set_step_s(setup.step_s);
  wire.set_integrator(to_wire<v1::Integrator>(setup.integrator));
  assign(*wire.mutable_gravity_m_per_s2(), setup.gravity_m_per_s2);
  wire.set_fluid_density_kg_per_m3(setup.fluid_density_kg_per_m3);
  for (const double length : setup.periodic_length_m) wire.add_periodic_length_m(length);
  for (const BodySpecification& body : setup.bodies) write_body(body, *wire.add_bodies());
  for (const SpringSpecification& spring : setup.springs) write_spring(spring, *wire.add_springs());
  wire.set_trace_directory(setup.trace_directory);
}

void read(const v1::BodySetup& wire, BodySetup& setup) {
  require_at_most(static_cast<std::size_t>(wire.bodies_size()), kLimits.bodies, "bodies");
  require_at_most(static_cast<std::size_t>(wire.springs_size()), kLimits.springs, "springs");
  setup.step_s = read_finite(wire.step_s(), "step_s");
  setup.integrator = from_wire(wire.integrator(), Integrator::runge_kutta_4, "integrator");
  setup.gravity_m_per_s2 = read_vector<Eigen::Vector3d>(wire.gravity_m_per_s2(), "gravity_m_per_s2");
  setup.fluid_density_kg_per_m3 = read_finite(wire.fluid_density_kg_per_m3(), "fluid_density_kg_per_m3");
  const auto lengths = read_vector<Eigen::Vector3d>(wire.periodic_length_m(), "periodic_length_m");
  setup.periodic_length_m = {lengths[0], lengths[1], lengths[2]};
  setup.bodies.clear();
  for (const v1::BodySpecification& body : wire.bodies()) setup.bodies.push_back(read_body(body));
  setup.springs.clear();
  for (const v1::SpringSpecification& spring : wire.springs()) {
    setup.springs.push_back(read_spring(spring, setup.bodies.size()));
  }
  setup.trace_directory = read_path(wire.trace_directory(), "trace_directory");
}

}  // namespace copepod::conversion
