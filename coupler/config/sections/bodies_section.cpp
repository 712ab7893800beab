#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {

using nlohmann::ordered_json;

void declare(Keys& keys, Shape& shape) {
  keys.choice("shape", shape.kind, shape_names, "Shape of the body.");
  keys.number(required("radius_m"), shape.radius_m, Range::positive,
              "Radius of the sphere, or of the capsule's hemispheres and cylinder [m].");
  const bool capsule = shape.kind == ShapeKind::capsule;
  keys.number(
      keys.needed("length_m", capsule), shape.length_m, Range::not_negative,
      "Length of a capsule's cylinder part [m]: the total length is this plus two radii. Needed for capsules, 0 "
      "for spheres.");
  Reader* reader = keys.reader();
  if (reader == nullptr || capsule || shape.length_m <= 0 || reader->problems().any_under(reader->path_of("shape")))
    return;
  reader->reject("length_m",
                 "is given for a sphere (only capsules have a cylinder part). Remove it, or use shape: capsule.");
}

void declare_direction(Keys& keys, const Key& key, Eigen::Vector3d& direction, const char* description) {
  keys.numbers(key, direction, description);
  Reader* reader = keys.reader();
  if (reader == nullptr) return;
  const double length = direction.norm();
  // A direction that is normalised already must keep its bits: the resolved case is read again.
  if (std::abs(length - 1.0) < 1e-15) return;
  if (length > 0) {
    direction /= length;
    return;
  }
  if (reader->has(key.name)) reader->reject(key.name, "is zero (it has no direction). Give a vector like [0, 0, 1].");
  direction = Eigen::Vector3d::UnitZ();
}

void declare_names(Keys& keys, const Key& key, std::vector<std::string>& names, std::size_t count,
                   const std::string& remedy, const char* description) {
  keys.words(key, names, count, description);
  Reader* reader = keys.reader();
  if (reader == nullptr || names.size() == count) return;
  reader->reject(key.name, "names " + std::to_string(names.size()) + " " + key.name + " (" + remedy);
  names.assign(count, "");
}

namespace {

void read_anchors(Reader& reader, Eigen::Vector3d& anchor_A_m, Eigen::Vector3d& anchor_B_m) {
  if (!reader.has("anchors_m")) return;
  const std::array anchors{&anchor_A_m, &anchor_B_m};
  if (reader.size("anchors_m") != anchors.size())
    return reader.reject("anchors_m", "needs two vectors (one per body). Write [[x, y, z], [x, y, z]].");
  const Value both = *reader.raw("anchors_m");
  for (std::size_t end = 0; end < anchors.size(); ++end) {
    // A list in a list has no keys, so the position of each anchor serves as its key.
    Value wrapped = Value::mapping();
    wrapped.add(std::to_string(end), both.items[end]);
    Reader anchor(&wrapped, reader.path_of("anchors_m"), reader.problems());
    *anchors[end] = anchor.numbers(std::to_string(end), 3);
  }
}

}  // namespace

void declare_anchors(Keys& keys, Eigen::Vector3d& anchor_A_m, Eigen::Vector3d& anchor_B_m, const char* description) {
  if (Reader* reader = keys.reader()) read_anchors(*reader, anchor_A_m, anchor_B_m);
  if (ordered_json* resolved = keys.resolved())
    (*resolved)["anchors_m"] = ordered_json::array({anchor_A_m, anchor_B_m});
  if (keys.describes())
    keys.describe("anchors_m", schema_of_list(schema_of_list(schema_of_number(Range::any), 3), 2), description);
}

void declare_orientation(Keys& keys, Eigen::Vector4d& q, const char* description) {
  keys.numbers("orientation_wxyz", q, description);
  Reader* reader = keys.reader();
  if (reader == nullptr) return;
  const double norm = q.norm();
  if (std::abs(norm - 1.0) < 1e-15) return;
  if (std::abs(norm - 1.0) < 1e-3) {
    q = q / norm;
    return;
  }
  reader->reject("orientation_wxyz",
                 "has length " + rounded_text(norm) +
                     " (an orientation is a unit quaternion). Normalise it; no rotation is [1, 0, 0, 0].");
  q = {1, 0, 0, 0};
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
void declare_prescribed_motion(Keys& keys, SingleBody& body, double step_s) {
  keys.section(
      required("prescribed"),
      "Velocities that vary in time; they replace those at the start. The coupler moves the body: nothing may be "
      "attached to it, and it pushes no other body.",
      [&](Keys& prescribed) {
        prescribed.numbers("velocity_m_per_s", body.velocity_m_per_s, "Velocity for a signal of 1, world frame.");
        prescribed.numbers("angular_velocity_rad_per_s", body.angular_velocity_rad_per_s,
                           "Angular velocity for a signal of 1, world frame.");
        prescribed.section(required("signal"), "Factor of both velocities.", [&](Keys& signal) {
          if (!body.signal) body.signal.emplace();
          declare(signal, *body.signal, step_s, {factor_of_velocities});
        });
      });
}

/// Whether the motion is a section.
bool has_prescribed_motion(Keys& keys, SingleBody& body) {
  Reader* reader = keys.reader();
  if (reader == nullptr) return body.signal.has_value();
  const Value* motion = reader->raw("motion");
  if (motion == nullptr || motion->kind != Value::Kind::mapping) return false;
  body.motion = MotionKind::prescribed;
  for (const char* key : {"velocity_m_per_s", "angular_velocity_rad_per_s"}) {
    if (reader->has(key))
      reader->reject(key, "is given beside motion: {prescribed: …} (which holds the velocities). Remove it.");
  }
  return true;
}

}  // namespace

void declare(Keys& keys, SingleBody& body, double step_s) {
  keys.name(required("name"), body.name, "Unique name.");
  declare(keys, body.shape);
  keys.number(required("mass_kg"), body.mass_kg, Range::positive, "Mass.");
  keys.numbers(required("position_m"), body.position_m, "Centre of mass at the start [m].");
  declare_orientation(keys, body.orientation_wxyz,
                      "Orientation at the start: unit quaternion. A capsule lies along its own z axis.");
  const bool is_section = has_prescribed_motion(keys, body);
  if (keys.when(!is_section)) {
    keys.numbers("velocity_m_per_s", body.velocity_m_per_s, "Velocity at the start.");
    keys.numbers("angular_velocity_rad_per_s", body.angular_velocity_rad_per_s,
                 "Angular velocity at the start, world frame.");
    keys.choice(
        "motion", body.motion, motion_names,
        "free; fixed: never moves; prescribed: keeps its velocities; axis: moves along and rotates about `axis` "
        "only; {prescribed: …}: moves as a function of time.");
  }
  if (keys.when(is_section))
    keys.either("motion", [&](Keys& motion) { declare_prescribed_motion(motion, body, step_s); });
  declare_direction(keys, "axis", body.axis, "For motion: axis; it is normalised.");
}

void declare(Keys& keys, NamedSpring& spring) {
  declare_names(keys, required("bodies"), spring.bodies, 2, "a spring joins two). Write bodies: [a, b].",
                "Names of the two bodies.");
  keys.number(required("stiffness_N_per_m"), spring.stiffness_N_per_m, Range::not_negative, "Stiffness k.");
  keys.number("damping_N_s_per_m", spring.damping_N_s_per_m, Range::not_negative, "Damping γ.");
  keys.number(required("rest_length_m"), spring.rest_length_m, Range::not_negative,
              "Distance between the anchors at which the force is zero.");
  declare_anchors(keys, spring.anchor_A_m, spring.anchor_B_m,
                  "Attachment points in the frame of each body, relative to its centre. Default: the centres.");
}

namespace {

/// Keys of what acts along the motion of a joint, of hinge and slider.
struct MotionKeys {
  JointKind kind;
  const char* stiffness;
  const char* damping;
  const char* rest;
  const char* limits;
  std::array<const char*, 4> descriptions;
};

const std::array<MotionKeys, 2> motion_keys{{
    {JointKind::hinge,
     "stiffness_N_m_per_rad",
     "damping_N_m_s_per_rad",
     "rest_rad",
     "limits_rad",
     {"Of a spring in a hinge.", "Of a damper in a hinge.",
      "Angle from the start at which the spring of a hinge is relaxed, of the first body relative to the second; "
      "within half a turn.",
      "Lowest and highest angle of a hinge from the start, of the first body relative to the second; between -3 and "
      "3. A stop takes the motion up. Default: no limits."}},
    {JointKind::slider,
     "stiffness_N_per_m",
     "damping_N_s_per_m",
     "rest_m",
     "limits_m",
     {"Of a spring along a slider.", "Of a damper along a slider.",
      "Motion from the start at which the spring of a slider is relaxed.",
      "Lowest and highest motion of a slider from the start. A stop takes the motion up. Default: no limits."}},
}};

void declare_motion(Keys& keys, const MotionKeys& names, NamedJoint& joint) {
  keys.number(names.stiffness, joint.stiffness, Range::not_negative, names.descriptions[0]);
  keys.number(names.damping, joint.damping, Range::not_negative, names.descriptions[1]);
  keys.number(names.rest, joint.rest, Range::any, names.descriptions[2]);
  Reader* reader = keys.reader();
  const bool has_limits = reader != nullptr ? reader->has(names.limits) : !joint.limits.isZero(0.0);
  if (keys.when(has_limits)) keys.numbers(keys.needed(names.limits), joint.limits, names.descriptions[3]);
  if (reader != nullptr && has_limits && joint.limits.isZero(0.0))
    reader->reject(names.limits, "leaves no room (both are 0). Use kind: fixed.");
}

}  // namespace

void declare(Keys& keys, NamedJoint& joint, double step_s) {
  keys.name(required("name"), joint.name, "Name of the joint.");
  joint.bodies.resize(2);
  if (!keys.kind(
          joint.kind, joint_names,
          "ball: one point in common; hinge: and an axis; slider: moves along an axis without turning; fixed: no "
          "relative motion; distance: a rod without mass; model: as body.model has it, in resolved cases."))
    return;
  declare_names(keys, required("bodies"), joint.bodies, 2, "a joint has two). Write bodies: [a, b], or [a, world].",
                "Names of the two bodies, or of a body and world.");
  if (!keys.when(joint.kind != JointKind::model)) return;
  if (keys.when(joint.kind == JointKind::distance))
    declare_anchors(keys, joint.anchors_m[0], joint.anchors_m[1],
                    "For distance: ends of the rod in the frame of each body, relative to its centre; in the world a "
                    "place. Default: the centres.");
  if (keys.when(joint.kind != JointKind::distance))
    keys.numbers(keys.needed("anchor_m"), joint.anchor_m,
                 "The point in common at the start, in the world. Not for distance.");
  if (keys.when(has_axis(joint.kind)))
    declare_direction(keys, keys.needed("axis"), joint.axis,
                      "Direction of the axis at the start, in the world. For hinge and slider.");
  for (const MotionKeys& names : motion_keys)
    if (keys.when(joint.kind == names.kind)) declare_motion(keys, names, joint);
  if (!keys.when(has_motion(joint.kind))) return;
  const bool turns = joint.kind == JointKind::hinge;
  keys.section<Signal>(
      "signal", joint.signal,
      "How a hinge, slider or rod moves, the first body relative to the second: what it has turned [rad] "
      "or moved [m] is the signal less its value at the start. Default: it moves freely.",
      [&](Keys& below, Signal& signal) {
        declare(below, signal, step_s,
                {{"amplitude_rad", "Amplitude of the angle of a hinge [rad].", turns},
                 {"amplitude_m", "Amplitude of the motion of a slider or rod [m].", !turns}});
      });
}

void declare(Keys& keys, NamedGroup& group) {
  keys.name(required("name"), group.name, "Name in cycles.csv and summary.json.");
  keys.words(required("bodies"), group.bodies, 0, "Names of the bodies.");
  const std::set<std::string> distinct(group.bodies.begin(), group.bodies.end());
  if (Reader* reader = keys.reader(); reader != nullptr && (distinct.empty() || distinct.size() != group.bodies.size()))
    reader->reject("bodies", "is empty or names a body twice (its motion is that of its bodies). List each once.");
  declare_direction(keys, "axis", group.axis, "Own axis at the start, in the world; it is carried along.");
  keys.integer("period_steps", group.period_steps, Range::not_negative,
               "Period of the cycles. Default: 0, that of what drives the bodies.");
}

}  // namespace copepod::coupler
