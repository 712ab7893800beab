#include <cmath>

#include "config/sections/sections.hpp"

namespace copepod::coupler {

Shape read_shape(Reader& reader) {
  Shape shape;
  shape.kind = reader.choice("shape", shape_names, std::optional(ShapeKind::sphere));
  shape.radius_m = reader.number("radius_m", Range::positive);
  const bool capsule = shape.kind == ShapeKind::capsule;
  shape.length_m =
      reader.number("length_m", Range::not_negative, capsule ? std::optional<double>() : std::optional(0.0));
  if (!capsule && shape.length_m > 0) {
    reader.problems().error(reader.path_of("length_m"),
                            reader.path_of("length_m") +
                                " is given for a sphere (only capsules have a cylinder part). "
                                "Remove it, or use shape: capsule.");
  }
  return shape;
}

void add_shape(Value& section, const Shape& shape) {
  section.add("shape", word(shape_names, shape.kind));
  section.add("radius_m", Value::of_number(shape.radius_m));
  section.add("length_m", Value::of_number(shape.length_m));
}

Eigen::Vector3d read_direction(Reader& reader, const std::string& key, const Eigen::Vector3d& otherwise) {
  Eigen::Vector3d direction = reader.numbers(key, 3, otherwise);
  const double length = direction.norm();
  // A direction that is normalised already must keep its bits: the resolved case is read again.
  if (std::abs(length - 1.0) < 1e-15) return direction;
  if (length > 0) return direction / length;
  reader.problems().error(reader.path_of(key),
                          reader.path_of(key) + " is zero (it has no direction). Give a vector like [0, 0, 1].");
  return otherwise;
}

Eigen::Vector4d read_orientation(Reader& body) {
  Eigen::Vector4d q = body.numbers("orientation_wxyz", 4, Eigen::Vector4d(1, 0, 0, 0));
  const double norm = q.norm();
  if (std::abs(norm - 1.0) < 1e-15) return q;
  if (std::abs(norm - 1.0) < 1e-3) return q / norm;
  body.problems().error(body.path_of("orientation_wxyz"),
                        body.path_of("orientation_wxyz") + " has length " + shortest_text(norm) +
                            " (an orientation is a unit quaternion). Normalise it; no rotation is [1, 0, 0, 0].");
  return {1, 0, 0, 0};
}

BodySpecification read_body(Reader body) {
  BodySpecification result;
  result.name = body.text("name");
  result.shape = read_shape(body);
  result.mass_kg = body.number("mass_kg", Range::positive);
  result.position_m = body.numbers("position_m", 3);
  result.orientation_wxyz = read_orientation(body);
  result.velocity_m_per_s = body.numbers("velocity_m_per_s", 3, Eigen::VectorXd::Zero(3));
  result.angular_velocity_rad_per_s = body.numbers("angular_velocity_rad_per_s", 3, Eigen::VectorXd::Zero(3));
  result.motion = body.choice("motion", motion_names, std::optional(MotionKind::free));
  result.axis = read_direction(body, "axis", Eigen::Vector3d::UnitZ());
  return result;
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

NamedSpring read_spring(Reader spring) {
  NamedSpring result;
  const std::vector<std::string> bodies = spring.words("bodies");
  if (bodies.size() == 2) {
    result.bodies = {bodies[0], bodies[1]};
  } else {
    spring.problems().error(spring.path_of("bodies"), spring.path_of("bodies") + " names " +
                                                          std::to_string(bodies.size()) +
                                                          " bodies (a spring joins two). Write bodies: [a, b].");
  }
  result.stiffness_N_per_m = spring.number("stiffness_N_per_m", Range::not_negative);
  result.damping_N_s_per_m = spring.number("damping_N_s_per_m", Range::not_negative, 0.0);
  result.rest_length_m = spring.number("rest_length_m", Range::not_negative);
  if (spring.has("anchors_m")) {
    const std::size_t anchors = spring.size("anchors_m");
    if (anchors != 2) {
      spring.problems().error(
          spring.path_of("anchors_m"),
          spring.path_of("anchors_m") + " needs two vectors (one per body). Write [[x, y, z], [x, y, z]].");
      return result;
    }
    const Value both = *spring.raw("anchors_m");
    const std::array ends{&result.anchor_A_m, &result.anchor_B_m};
    for (std::size_t end = 0; end < 2; ++end) {
      // A list in a list has no keys, so the position of each anchor serves as its key.
      Value wrapped = Value::mapping();
      wrapped.add(std::to_string(end), both.items[end]);
      Reader anchor(&wrapped, spring.path_of("anchors_m"), spring.problems());
      *ends[end] = anchor.numbers(std::to_string(end), 3);
    }
  }
  return result;
}

Value resolved_spring(const NamedSpring& spring) {
  Value section = Value::mapping();
  section.add("bodies", Value::of_words({spring.bodies[0], spring.bodies[1]}));
  section.add("stiffness_N_per_m", Value::of_number(spring.stiffness_N_per_m));
  section.add("damping_N_s_per_m", Value::of_number(spring.damping_N_s_per_m));
  section.add("rest_length_m", Value::of_number(spring.rest_length_m));
  Value anchors = Value::sequence();
  anchors.add(Value::of_vector(spring.anchor_A_m)).add(Value::of_vector(spring.anchor_B_m));
  return section.add("anchors_m", std::move(anchors));
}

NamedForce read_force(Reader force) {
  NamedForce result;
  result.name = force.text("body");
  const bool constant = force.has("constant_N");
  const bool sinusoidal = force.has("sinusoidal");
  if (constant == sinusoidal) {
    force.problems().error(force.path_of("constant_N"),
                           "a force on '" + result.name +
                               "' needs exactly one of constant_N and sinusoidal "
                               "(it has both or none). Split it into two entries, or add the missing one.");
  }
  if (constant) result.amplitude_N = force.numbers("constant_N", 3);
  {
    Reader wave = force.section("sinusoidal");
    if (sinusoidal) {
      result.amplitude_N = wave.numbers("amplitude_N", 3);
      result.period_steps = wave.integer("period_steps", Range::positive);
      result.phase_lag_steps = wave.integer("phase_lag_steps", Range::any, 0);
    }
  }
  result.start_step = force.integer("start_step", Range::not_negative, 0);
  const Value* stop = force.raw("stop_step");
  if (stop != nullptr && stop->text != "never") result.stop_step = force.integer("stop_step", Range::not_negative);
  return result;
}

Value resolved_force(const NamedForce& force) {
  Value section = Value::mapping();
  section.add("body", Value::of_text(force.name));
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
  return section.add("stop_step", force.stop_step == DrivingTerm::never ? Value::of_text("never")
                                                                        : Value::of_integer(force.stop_step));
}

}  // namespace copepod::coupler
