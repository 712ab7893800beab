#include "config/sections/resolved.hpp"

#include "config/sections/names.hpp"
#include "config/yaml/yaml_text.hpp"
#include "contract/digest.hpp"

namespace copepod::coupler {
namespace {

template <typename E, std::size_t N>
Value word(const std::array<Choice<E>, N>& choices, E value) {
  return Value::of_text(name_of(choices, value));
}

Value words(const std::vector<std::string>& texts) {
  Value list = Value::sequence();
  for (const std::string& text : texts) list.add(Value::of_text(text));
  return list;
}

Value resolved_face(const Boundary& boundary) {
  Value face = Value::mapping();
  switch (boundary.kind) {
    case BoundaryKind::velocity:
      return face.add("velocity_m_per_s", Value::of_vector(boundary.velocity_m_per_s));
    case BoundaryKind::pressure:
      return face.add("pressure_Pa", Value::of_number(boundary.pressure_Pa));
    default:
      return word(boundary_names, boundary.kind);
  }
}

Value resolved_boundaries(const FluidCase& fluid) {
  Value boundaries = Value::mapping();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Value faces = Value::mapping();
    faces.add("low", resolved_face(fluid.boundaries[2 * axis]));
    faces.add("high", resolved_face(fluid.boundaries[2 * axis + 1]));
    boundaries.add(axis_names[axis], std::move(faces));
  }
  return boundaries;
}

Value resolved_fluid(const FluidCase& fluid) {
  Value section = Value::mapping();
  section.add("solver", word(solver_names, fluid.solver));
  section.add("density_kg_per_m3", Value::of_number(fluid.density_kg_per_m3));
  section.add("kinematic_viscosity_m2_per_s", Value::of_number(fluid.kinematic_viscosity_m2_per_s));
  section.add("cell_size_m", Value::of_number(fluid.cell_size_m));
  if (fluid.relaxation_time) section.add("relaxation_time", Value::of_number(*fluid.relaxation_time));
  Value cells = Value::sequence();
  for (const std::int64_t count : fluid.domain_cells) cells.add(Value::of_integer(count));
  section.add("domain_cells", std::move(cells));
  section.add("boundaries", resolved_boundaries(fluid));
  section.add("no_slip_plane", word(plane_names, fluid.no_slip_plane));
  Value planes = Value::sequence();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (fluid.symmetry_planes[axis]) planes.add(Value::of_text(axis_names[axis]));
  }
  section.add("symmetry_planes", std::move(planes));
  section.add("body_force_N_per_m3", Value::of_vector(fluid.body_force_N_per_m3));
  section.add("collision", word(collision_names, fluid.collision));
  section.add("moving_boundary", word(moving_boundary_names, fluid.moving_boundary));
  section.add("refill", word(refill_names, fluid.refill));
  return section.add("precision", word(precision_names, fluid.precision));
}

void add_shape(Value& section, const Shape& shape) {
  section.add("shape", word(shape_names, shape.kind));
  section.add("radius_m", Value::of_number(shape.radius_m));
  section.add("length_m", Value::of_number(shape.length_m));
}

Value resolved_published(const PublishedFigures& figures) {
  const std::string of_bodies = "Re_bodies.";
  Value section = Value::mapping();
  Value bodies = Value::mapping();
  for (const auto& [key, value] : figures) {
    if (key.starts_with(of_bodies))
      bodies.add(key.substr(of_bodies.size()), Value::of_number(value));
    else
      section.add(key, Value::of_number(value));
  }
  if (!bodies.entries.empty()) section.add("Re_bodies", std::move(bodies));
  return section;
}

Value resolved_swimmer(const Swimmer& swimmer) {
  Value section = Value::mapping();
  section.add("name", Value::of_text(swimmer.name));
  section.add("center_m", Value::of_vector(swimmer.center_m));
  section.add("axis", Value::of_vector(swimmer.axis));
  Value beads = Value::sequence();
  for (const Bead& bead : swimmer.beads) {
    Value item = Value::mapping();
    add_shape(item, bead.shape);
    beads.add(std::move(item.add("orientation", word(orientation_names, bead.orientation))));
  }
  section.add("beads", std::move(beads));
  section.add("bead_mass_kg", Value::of_number(swimmer.bead_mass_kg));
  section.add("rest_gap_m", Value::of_vector(Eigen::Vector2d(swimmer.rest_gap_m[0], swimmer.rest_gap_m[1])));
  Value spring = Value::mapping();
  spring.add("stiffness_N_per_m", Value::of_number(swimmer.stiffness_N_per_m));
  spring.add("damping_N_s_per_m", Value::of_number(swimmer.damping_N_s_per_m));
  section.add("spring", std::move(spring));
  Value stroke = Value::mapping();
  stroke.add("amplitude_N", Value::of_number(swimmer.stroke.amplitude_N));
  stroke.add("period_steps", Value::of_integer(swimmer.stroke.period_steps));
  stroke.add("phase_lag_steps", Value::of_integer(swimmer.stroke.phase_lag_steps));
  stroke.add("cycles", Value::of_integer(swimmer.stroke.cycles));
  section.add("stroke", std::move(stroke));
  if (!swimmer.published.empty()) section.add("published", resolved_published(swimmer.published));
  return section;
}

Value resolved_body(const BodySpecification& body) {
  Value section = Value::mapping();
  section.add("name", Value::of_text(body.name));
  add_shape(section, body.shape);
  section.add("mass_kg", Value::of_number(body.mass_kg));
  section.add("position_m", Value::of_vector(body.position_m));
  section.add("orientation_wxyz", Value::of_vector(body.orientation_wxyz));
  section.add("velocity_m_per_s", Value::of_vector(body.velocity_m_per_s));
  section.add("angular_velocity_rad_per_s", Value::of_vector(body.angular_velocity_rad_per_s));
  section.add("motion", word(motion_names, body.motion));
  return section.add("axis", Value::of_vector(body.axis));
}

Value resolved_spring(const NamedSpring& spring) {
  Value section = Value::mapping();
  section.add("bodies", words({spring.bodies[0], spring.bodies[1]}));
  section.add("stiffness_N_per_m", Value::of_number(spring.stiffness_N_per_m));
  section.add("damping_N_s_per_m", Value::of_number(spring.damping_N_s_per_m));
  section.add("rest_length_m", Value::of_number(spring.rest_length_m));
  Value anchors = Value::sequence();
  for (const Eigen::Vector3d& anchor : spring.anchors_m) anchors.add(Value::of_vector(anchor));
  return section.add("anchors_m", std::move(anchors));
}

Value resolved_force(const NamedForce& force) {
  Value section = Value::mapping();
  section.add("body", Value::of_text(force.body));
  if (force.period_steps == 0) {
    section.add("constant_N", Value::of_vector(force.amplitude_N));
  } else {
    Value wave = Value::mapping();
    wave.add("amplitude_N", Value::of_vector(force.amplitude_N));
    wave.add("period_steps", Value::of_integer(force.period_steps));
    wave.add("phase_lag_steps", Value::of_integer(force.phase_lag_steps));
    section.add("sinusoidal", std::move(wave));
  }
  section.add("start_step", Value::of_integer(force.start_step));
  return section.add("stop_step",
                     force.stop_step ? Value::of_integer(*force.stop_step) : Value::of_text("never"));
}

Value resolved_output(const OutputCase& output) {
  Value trajectory = Value::mapping();
  trajectory.add("every_steps", Value::of_integer(output.trajectory_every_steps));
  trajectory.add("from_step", Value::of_integer(output.trajectory_from_step));
  Value fields = Value::mapping();
  fields.add("every_steps", Value::of_integer(output.fields_every_steps));
  Value mean = Value::sequence();
  for (const std::int64_t step : output.mean_over_steps) mean.add(Value::of_integer(step));
  fields.add("mean_over_steps", std::move(mean));
  fields.add("mean_every_steps", Value::of_integer(output.mean_every_steps));
  Value checkpoint = Value::mapping();
  checkpoint.add("every_steps", Value::of_integer(output.checkpoint_every_steps));
  checkpoint.add("every_wall_s", Value::of_number(output.checkpoint_every_wall_s));
  Value section = Value::mapping();
  section.add("trajectory", std::move(trajectory));
  section.add("fields", std::move(fields));
  section.add("checkpoint", std::move(checkpoint));
  section.add("wire", word(switch_names, output.wire));
  return section.add("trace", word(switch_names, output.trace));
}

Value resolved_services(const ServicesCase& services) {
  Value fluid = Value::mapping();
  fluid.add("ranks", Value::of_integer(services.fluid_ranks));
  fluid.add("command", words(services.fluid_command));
  Value body = Value::mapping();
  body.add("command", words(services.body_command));
  Value section = Value::mapping();
  section.add("fluid", std::move(fluid));
  section.add("body", std::move(body));
  section.add("transport", Value::of_text(services.transport));
  section.add("connect_deadline_s", Value::of_number(services.connect_deadline_s));
  return section.add("progress_deadline_s", Value::of_number(services.progress_deadline_s));
}

template <typename Item>
Value list(const std::vector<Item>& items, Value (*resolve)(const Item&)) {
  Value result = Value::sequence();
  for (const Item& item : items) result.add(resolve(item));
  return result;
}

}  // namespace

Value resolved(const Case& the_case) {
  Value top = Value::mapping();
  top.add("case", Value::of_text(the_case.name));
  if (!the_case.parameter_set.empty()) top.add("parameter_set", Value::of_text(the_case.parameter_set));
  top.add("fluid", resolved_fluid(the_case.fluid));
  if (the_case.given_step_s) top.add("step_s", Value::of_number(*the_case.given_step_s));
  Value body = Value::mapping();
  body.add("solver", word(body_solver_names, the_case.body.solver));
  top.add("body", std::move(body.add("integrator", word(integrator_names, the_case.body.integrator))));
  top.add("swimmers", list(the_case.swimmers, resolved_swimmer));
  top.add("bodies", list(the_case.bodies, resolved_body));
  top.add("springs", list(the_case.springs, resolved_spring));
  top.add("forces", list(the_case.forces, resolved_force));
  top.add("gravity_m_per_s2", Value::of_vector(the_case.gravity_m_per_s2));
  Value coupling = Value::mapping();
  coupling.add("scheme", word(scheme_names, SchemeKind::serial_explicit));
  coupling.add("load_averaging", word(averaging_names, the_case.load_averaging));
  top.add("coupling", std::move(coupling));
  Value run = Value::mapping();
  top.add("run", std::move(run.add("steps", Value::of_integer(the_case.steps))));
  top.add("output", resolved_output(the_case.output));
  return top.add("services", resolved_services(the_case.services));
}

std::string case_key(Case the_case) {
  Digest digest;
  for (Swimmer& swimmer : the_case.swimmers) swimmer.published.clear();
  Value physics = resolved(the_case);
  std::erase_if(physics.entries, [](const Value::Entry& entry) {
    return entry.key == "run" || entry.key == "output" || entry.key == "services";
  });
  for (const char letter : to_yaml(physics))
    digest.add(static_cast<std::uint64_t>(static_cast<unsigned char>(letter)));
  return std::to_string(digest.value());
}

}  // namespace copepod::coupler
