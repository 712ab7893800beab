#include <cmath>
#include <set>
#include <tuple>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "contract/number_text.hpp"

namespace copepod::coupler {

using nlohmann::ordered_json;

Shape read_shape(Reader& reader) {
  Shape shape;
  shape.kind = reader.choice("shape", shape_names, std::optional(ShapeKind::sphere));
  shape.radius_m = reader.number("radius_m", Range::positive);
  const bool capsule = shape.kind == ShapeKind::capsule;
  shape.length_m =
      reader.number("length_m", Range::not_negative, capsule ? std::optional<double>() : std::optional(0.0));
  if (!capsule && shape.length_m > 0 && !reader.problems().any_under(reader.path_of("shape"))) {
    reader.reject("length_m",
                  "is given for a sphere (only capsules have a cylinder part). Remove it, or use shape: "
                  "capsule.");
  }
  return shape;
}

void add_shape(ordered_json& section, const Shape& shape) {
  section["shape"] = name_of(shape_names, shape.kind);
  section["radius_m"] = shape.radius_m;
  section["length_m"] = shape.length_m;
}

Eigen::Vector3d read_direction(Reader& reader, const std::string& key,
                               const std::optional<Eigen::VectorXd>& otherwise) {
  const bool required = !otherwise.has_value();
  Eigen::Vector3d direction = reader.numbers(key, 3, otherwise);
  const double length = direction.norm();
  // A direction that is normalised already must keep its bits: the resolved case is read again.
  if (std::abs(length - 1.0) < 1e-15) return direction;
  if (length > 0) return direction / length;
  if (!required || reader.has(key)) reader.reject(key, "is zero (it has no direction). Give a vector like [0, 0, 1].");
  return Eigen::Vector3d::UnitZ();
}

std::vector<std::string> read_names(Reader& reader, const std::string& key, std::size_t count,
                                    const std::string& remedy) {
  std::vector<std::string> names = reader.words(key);
  if (names.size() == count) return names;
  reader.reject(key, "names " + std::to_string(names.size()) + " " + key + " (" + remedy);
  return std::vector<std::string>(count);
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> read_anchors(Reader& reader) {
  std::array<Eigen::Vector3d, 2> anchors{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  if (!reader.has("anchors_m")) return {anchors[0], anchors[1]};
  if (reader.size("anchors_m") != anchors.size()) {
    reader.reject("anchors_m", "needs two vectors (one per body). Write [[x, y, z], [x, y, z]].");
    return {anchors[0], anchors[1]};
  }
  const Value both = *reader.raw("anchors_m");
  for (std::size_t end = 0; end < anchors.size(); ++end) {
    // A list in a list has no keys, so the position of each anchor serves as its key.
    Value wrapped = Value::mapping();
    wrapped.add(std::to_string(end), both.items[end]);
    Reader anchor(&wrapped, reader.path_of("anchors_m"), reader.problems());
    anchors[end] = anchor.numbers(std::to_string(end), 3);
  }
  return {anchors[0], anchors[1]};
}

ordered_json resolved_anchors(const Eigen::Vector3d& anchor_A_m, const Eigen::Vector3d& anchor_B_m) {
  return ordered_json::array({anchor_A_m, anchor_B_m});
}

Eigen::Vector4d read_orientation(Reader& body) {
  Eigen::Vector4d q = body.numbers("orientation_wxyz", 4, Eigen::Vector4d(1, 0, 0, 0));
  const double norm = q.norm();
  if (std::abs(norm - 1.0) < 1e-15) return q;
  if (std::abs(norm - 1.0) < 1e-3) return q / norm;
  body.reject("orientation_wxyz",
              "has length " + rounded_text(norm) +
                  " (an orientation is a unit quaternion). Normalise it; no rotation is [1, 0, 0, 0].");
  return {1, 0, 0, 0};
}

Eigen::Vector4d rotation_from_z(const Eigen::Vector3d& direction) {
  const double c = direction.z();
  const double s = std::hypot(direction.x(), direction.y());
  if (s == 0.0) return c > 0.0 ? Eigen::Vector4d(1, 0, 0, 0) : Eigen::Vector4d(0, 1, 0, 0);
  const double w = c >= 0.0 ? std::sqrt((1.0 + c) / 2.0) : s / std::sqrt(2.0 * (1.0 - c));
  return Eigen::Vector4d(w, -direction.y() / (2.0 * w), direction.x() / (2.0 * w), 0.0).normalized();
}

namespace {

/// motion: {prescribed: …}: velocities that vary in time.
void read_prescribed_motion(Reader& body, double step_s, SingleBody& result) {
  for (const char* key : {"velocity_m_per_s", "angular_velocity_rad_per_s"}) {
    if (body.has(key))
      body.reject(key, "is given beside motion: {prescribed: …} (which holds the velocities). Remove it.");
  }
  Reader motion = body.section("motion");
  Reader prescribed = motion.section("prescribed");
  result.motion = MotionKind::prescribed;
  result.velocity_m_per_s = prescribed.numbers("velocity_m_per_s", 3, Eigen::VectorXd::Zero(3));
  result.angular_velocity_rad_per_s = prescribed.numbers("angular_velocity_rad_per_s", 3, Eigen::VectorXd::Zero(3));
  result.signal = read_signal(prescribed.section("signal"), step_s, factor_key);
}

}  // namespace

SingleBody read_body(Reader body, double step_s) {
  SingleBody result;
  result.name = body.name("name");
  result.shape = read_shape(body);
  result.mass_kg = body.number("mass_kg", Range::positive);
  result.position_m = body.numbers("position_m", 3);
  result.orientation_wxyz = read_orientation(body);
  const Value* motion = body.raw("motion");
  if (motion != nullptr && motion->kind == Value::Kind::mapping) {
    read_prescribed_motion(body, step_s, result);
  } else {
    result.velocity_m_per_s = body.numbers("velocity_m_per_s", 3, Eigen::VectorXd::Zero(3));
    result.angular_velocity_rad_per_s = body.numbers("angular_velocity_rad_per_s", 3, Eigen::VectorXd::Zero(3));
    result.motion = body.choice("motion", motion_names, std::optional(MotionKind::free));
  }
  result.axis = read_direction(body, "axis", Eigen::Vector3d::UnitZ());
  return result;
}

ordered_json resolved_body(const SingleBody& body) {
  ordered_json section{{"name", body.name}};
  add_shape(section, body.shape);
  section["mass_kg"] = body.mass_kg;
  section["position_m"] = body.position_m;
  section["orientation_wxyz"] = body.orientation_wxyz;
  ordered_json velocities{{"velocity_m_per_s", body.velocity_m_per_s},
                          {"angular_velocity_rad_per_s", body.angular_velocity_rad_per_s}};
  if (body.signal) {
    velocities["signal"] = resolved_signal(*body.signal, factor_key);
    section["motion"] = {{"prescribed", velocities}};
  } else {
    section.update(velocities);
    section["motion"] = name_of(motion_names, body.motion);
  }
  section["axis"] = body.axis;
  return section;
}

NamedSpring read_spring(Reader spring) {
  NamedSpring result;
  result.bodies = read_names(spring, "bodies", 2, "a spring joins two). Write bodies: [a, b].");
  result.stiffness_N_per_m = spring.number("stiffness_N_per_m", Range::not_negative);
  result.damping_N_s_per_m = spring.number("damping_N_s_per_m", Range::not_negative, 0.0);
  result.rest_length_m = spring.number("rest_length_m", Range::not_negative);
  std::tie(result.anchor_A_m, result.anchor_B_m) = read_anchors(spring);
  return result;
}

ordered_json resolved_spring(const NamedSpring& spring) {
  return {{"bodies", spring.bodies},
          {"stiffness_N_per_m", spring.stiffness_N_per_m},
          {"damping_N_s_per_m", spring.damping_N_s_per_m},
          {"rest_length_m", spring.rest_length_m},
          {"anchors_m", resolved_anchors(spring.anchor_A_m, spring.anchor_B_m)}};
}

namespace {

const char* amplitude_of(JointKind kind) { return kind == JointKind::hinge ? "amplitude_rad" : "amplitude_m"; }

/// Keys of what acts along the motion of a joint.
struct MotionKeys {
  const char* stiffness;
  const char* damping;
  const char* rest;
  const char* limits;
};

MotionKeys motion_keys_of(JointKind kind) {
  if (kind == JointKind::hinge) return {"stiffness_N_m_per_rad", "damping_N_m_s_per_rad", "rest_rad", "limits_rad"};
  return {"stiffness_N_per_m", "damping_N_s_per_m", "rest_m", "limits_m"};
}

}  // namespace

NamedJoint read_joint(Reader joint, double step_s) {
  NamedJoint result;
  result.bodies.resize(2);
  const auto kind = joint.kind(joint_names);
  if (!kind) return result;
  result.kind = *kind;
  result.name = joint.name("name");
  result.bodies = read_names(joint, "bodies", 2, "a joint has two). Write bodies: [a, b], or [a, world].");
  if (result.kind == JointKind::model) return result;
  if (result.kind == JointKind::distance) {
    std::tie(result.anchors_m[0], result.anchors_m[1]) = read_anchors(joint);
  } else {
    result.anchor_m = joint.numbers("anchor_m", 3);
  }
  if (has_axis(result.kind)) {
    const MotionKeys keys = motion_keys_of(result.kind);
    result.axis = read_direction(joint, "axis", {});
    result.stiffness = joint.number(keys.stiffness, Range::not_negative, 0.0);
    result.damping = joint.number(keys.damping, Range::not_negative, 0.0);
    result.rest = joint.number(keys.rest, Range::any, 0.0);
    if (joint.has(keys.limits)) {
      result.limits = joint.numbers(keys.limits, 2);
      if (result.limits.isZero(0.0)) {
        joint.problems().error(joint.path_of(keys.limits),
                               joint.path_of(keys.limits) + " leaves no room (both are 0). Use kind: fixed.");
      }
    }
  }
  if (has_motion(result.kind) && joint.has("signal"))
    result.signal = read_signal(joint.section("signal"), step_s, amplitude_of(result.kind));
  return result;
}

ordered_json resolved_joint(const NamedJoint& joint) {
  ordered_json section{{"name", joint.name}, {"kind", name_of(joint_names, joint.kind)}, {"bodies", joint.bodies}};
  if (joint.kind == JointKind::model) return section;
  if (joint.kind == JointKind::distance) {
    section["anchors_m"] = resolved_anchors(joint.anchors_m[0], joint.anchors_m[1]);
  } else {
    section["anchor_m"] = joint.anchor_m;
  }
  if (has_axis(joint.kind)) {
    const MotionKeys keys = motion_keys_of(joint.kind);
    section["axis"] = joint.axis;
    section[keys.stiffness] = joint.stiffness;
    section[keys.damping] = joint.damping;
    section[keys.rest] = joint.rest;
    if (!joint.limits.isZero(0.0)) section[keys.limits] = joint.limits;
  }
  if (joint.signal) section["signal"] = resolved_signal(*joint.signal, amplitude_of(joint.kind));
  return section;
}

NamedGroup read_group(Reader group) {
  NamedGroup result;
  result.name = group.name("name");
  result.bodies = group.words("bodies");
  const std::set<std::string> distinct(result.bodies.begin(), result.bodies.end());
  if (result.bodies.empty() || distinct.size() != result.bodies.size()) {
    group.problems().error(group.path_of("bodies"),
                           group.path_of("bodies") +
                               " is empty or names a body twice (its motion is that of its bodies). List each once.");
  }
  result.axis = read_direction(group, "axis", Eigen::Vector3d::UnitZ());
  result.period_steps = group.integer("period_steps", Range::not_negative, 0);
  return result;
}

ordered_json resolved_group(const NamedGroup& group) {
  return {{"name", group.name}, {"bodies", group.bodies}, {"axis", group.axis}, {"period_steps", group.period_steps}};
}

}  // namespace copepod::coupler
