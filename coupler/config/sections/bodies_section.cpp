#include <cmath>
#include <fstream>
#include <numbers>
#include <set>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "config/shapes/mesh_file.hpp"
#include "config/yaml/keys.hpp"
#include "contract/errors.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::coupler {

using nlohmann::ordered_json;

namespace {

/// Three lengths.
void declare_extents(Keys& keys, const char* key, Eigen::Vector3d& extents_m, const char* description) {
  keys.numbers(keys.needed(key), extents_m, description);
  if (!keys.reads() || extents_m.minCoeff() > 0.0) return;
  keys.reject_if(!keys.has_errors(key), key, "has an entry that is not positive (a length). Give three lengths [m].");
  extents_m = Eigen::Vector3d::Ones();
}

/// @throws CaseError if it cannot be read
std::string bytes_of_mesh_file(const std::string& path) {
  constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 30;
  std::error_code error;
  std::ifstream stream(path, std::ios::binary);
  if (!stream || !std::filesystem::is_regular_file(path, error))
    throw CaseError("it cannot be read. Give the path of an STL, OBJ or PLY file, relative to the case file");
  if (std::filesystem::file_size(path, error) > most_bytes) throw CaseError("it is larger than 1 GiB");
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The mesh of a shape: a file, or its content as resolved cases have it.
void declare_mesh(Keys& keys, Shape& shape) {
  if (ordered_json* resolved = keys.resolved()) (*resolved)["text"] = to_obj(*shape.mesh);
  keys.describe("file", {{"type", "string"}},
                "Of a mesh: path of an STL, OBJ or PLY file, relative to the case file. Its surface is closed.");
  keys.describe("text", {{"type", "string"}}, "Of a mesh: the OBJ file itself, as resolved cases have it.");
  double unit_m = 1.0;
  keys.number(keys.needed("unit_m", keys.has("file")), unit_m, Range::positive,
              "Of a mesh: the unit of length in its file. Needed beside file.");
  if (!keys.reads()) return;
  shape.mesh = std::make_shared<const TriangleMesh>(box_mesh(Eigen::Vector3d::Ones()));  // where it cannot be read
  const bool is_file = keys.has("file");
  if (is_file == keys.has("text"))
    return keys.reject("file", "and text are both given or both missing (one holds the mesh). Write file: NAME.stl.");
  const std::string path = is_file ? file_beside_case(keys, "file").string() : "";
  std::string text;
  if (!is_file) keys.text("text", text, "");
  if (keys.has_errors(is_file ? "file" : "text")) return;
  try {
    shape.mesh = std::make_shared<const TriangleMesh>(read_mesh(is_file ? bytes_of_mesh_file(path) : text, unit_m));
  } catch (const CaseError& error) {
    if (is_file)
      keys.reject("file", "is '" + path + "' (" + error.what() + ").");
    else
      keys.reject("text", std::string("cannot be used (") + error.what() + ").");
  }
}

void declare_part(Keys& keys, ShapePart& part);

/// The keys of a shape that is, or is not, part of another.
void declare_shape(Keys& keys, Shape& shape, bool is_part) {
  keys.choice("shape", shape.kind, shape_names, "Shape of the body.");
  const ShapeKind kind = shape.kind;
  const bool has_radius = is_round(shape) || kind == ShapeKind::cylinder;
  if (keys.when(has_radius))
    keys.number(keys.needed("radius_m"), shape.radius_m, Range::positive,
                "Radius of the sphere, or of the capsule's hemispheres and cylinder, or of the cylinder [m].");
  const bool has_length = kind == ShapeKind::capsule || kind == ShapeKind::cylinder;
  if (keys.when(has_radius))
    keys.number(keys.needed("length_m", has_length), shape.length_m,
                kind == ShapeKind::cylinder ? Range::positive : Range::not_negative,
                "Length of a cylinder, or of a capsule's cylinder part [m]: the total length of a capsule is this plus "
                "two radii. Needed for both, 0 for spheres.");
  if (keys.when(kind == ShapeKind::ellipsoid))
    declare_extents(keys, "semi_axes_m", shape.extents_m, "Semi-axes of an ellipsoid along its own x, y and z [m].");
  if (keys.when(kind == ShapeKind::box))
    declare_extents(keys, "edges_m", shape.extents_m, "Edges of a box along its own x, y and z [m].");
  if (keys.when(kind == ShapeKind::mesh)) declare_mesh(keys, shape);
  if (!is_part && keys.when(kind == ShapeKind::compound))
    keys.list<ShapePart>({"parts", Need::in_some_cases}, shape.parts,
                         "Of a compound: shapes whose union it is, none of them a compound. They may overlap.",
                         declare_part);
  keys.reject_if(kind == ShapeKind::compound && is_part, "shape",
                 "is compound, within a compound (parts are simple). Give its parts to the whole.");
  keys.reject_if(kind == ShapeKind::compound && shape.parts.empty() && !is_part, "parts",
                 "is empty or missing (a compound is the union of its parts). Give at least one.");
  keys.reject_if(kind == ShapeKind::sphere && shape.length_m > 0 && !keys.has_errors("shape"), "length_m",
                 "is given for a sphere (only capsules and cylinders have one). Remove it, or use shape: capsule.");
  if (has_radius || !keys.reads()) return;
  shape.radius_m = std::cbrt(make_solid(shape)->moments().volume / (4.0 / 3.0 * std::numbers::pi));
}

void declare_part(Keys& keys, ShapePart& part) {
  declare_shape(keys, part.shape, true);
  keys.numbers("position_m", part.position_m, "Place of the part in the frame of the whole [m].");
  declare_orientation(keys, part.orientation_wxyz, "Orientation in the frame of the whole: unit quaternion.");
}

/// motion: {prescribed: …}: velocities that vary in time.
void declare_prescribed_motion(Keys& keys, SingleBody& body, double step_s) {
  keys.section(required("prescribed"),
               "Velocities that vary in time; they replace those at the start. The coupler moves the body: nothing may "
               "be attached to it, and it pushes no other body.",
               [&](Keys& prescribed) {
                 prescribed.numbers("velocity_m_per_s", body.velocity_m_per_s,
                                    "Velocity for a signal of 1, world frame.");
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
  if (!keys.reads()) return body.signal.has_value();
  const Value* motion = keys.raw("motion");
  if (motion == nullptr || motion->kind != Value::Kind::mapping) return false;
  body.motion = MotionKind::prescribed;
  for (const char* key : {"velocity_m_per_s", "angular_velocity_rad_per_s"})
    keys.reject_if(keys.has(key), key,
                   "is given beside motion: {prescribed: …} (which holds the velocities). Remove it.");
  return true;
}

/// What acts along the motion of a hinge or slider.
void declare_motion(Keys& keys, NamedJoint& joint, const DescribedKey& stiffness, const DescribedKey& damping,
                    const DescribedKey& rest, const DescribedKey& limits_from_start) {
  keys.number(stiffness.name, joint.stiffness, Range::not_negative, stiffness.description);
  keys.number(damping.name, joint.damping, Range::not_negative, damping.description);
  keys.number(rest.name, joint.rest, Range::any, rest.description);
  const char* key = limits_from_start.name;
  if (!keys.when(keys.reads() ? keys.has(key) : joint.has_limits())) return;
  Eigen::Vector2d limits(joint.lowest, joint.highest);
  keys.numbers(keys.needed(key), limits, limits_from_start.description);
  joint.lowest = limits[0];
  joint.highest = limits[1];
  keys.reject_if(!joint.has_limits(), key, "leaves no room (both are 0). Use kind: fixed.");
}

}  // namespace

void declare(Keys& keys, Shape& shape) { declare_shape(keys, shape, false); }

void declare_mass(Keys& keys, GivenBody& body) {
  keys.reject_if(keys.has("density_kg_per_m3") == keys.has("mass_kg"), "mass_kg",
                 "and density_kg_per_m3 are both given, or neither (one follows from the other). Give exactly one.");
  keys.number({"mass_kg", Need::in_some_cases}, body.mass_kg, Range::positive, "Mass [kg].");
  std::optional<double> density_kg_per_m3;
  keys.number("density_kg_per_m3", density_kg_per_m3, Range::positive, "Density, instead of mass_kg.");
  if (density_kg_per_m3) body.mass_kg = *density_kg_per_m3 * volume_m3(body.shape);
  const bool has_inertia = keys.reads() ? keys.has("inertia_kg_m2") : !body.inertia_kg_m2.empty();
  if (keys.when(has_inertia)) {
    body.inertia_kg_m2.resize(6);
    keys.numbers(keys.needed("inertia_kg_m2"), Eigen::Map<Eigen::VectorXd>(body.inertia_kg_m2.data(), 6),
                 "Of a body that is not uniform: inertia about its centre of mass, axes of the shape's own frame: xx, "
                 "yy, zz, xy, xz, yz. Default: that of a uniform body.");
    keys.numbers("center_of_mass_m", body.center_of_mass_m,
                 "Beside inertia_kg_m2: the centre of mass in the shape's own frame [m]. Default: its origin.");
  } else {
    keys.reject_if(keys.has("center_of_mass_m"), "center_of_mass_m",
                   "is given without inertia_kg_m2 (a uniform body has its own). Give both.");
  }
}

void declare_direction(Keys& keys, const Key& key, Eigen::Vector3d& direction, const char* description) {
  keys.numbers(key, direction, description);
  if (!keys.reads()) return;
  const double length = direction.norm();
  // A direction that is normalised already must keep its bits: the resolved case is read again.
  if (std::abs(length - 1.0) < 1e-15) return;
  if (length > 0) {
    direction /= length;
    return;
  }
  keys.reject_if(keys.has(key.name), key.name, "is zero (it has no direction). Give a vector like [0, 0, 1].");
  direction = Eigen::Vector3d::UnitZ();
}

void declare_names(Keys& keys, const Key& key, std::vector<std::string>& names, std::size_t count,
                   const std::string& remedy, const char* description) {
  keys.words(key, names, count, description);
  if (!keys.reads() || names.size() == count) return;
  keys.reject(key.name, "names " + std::to_string(names.size()) + " " + key.name + " (" + remedy);
  names.assign(count, "");
}

void declare_anchors(Keys& keys, Eigen::Vector3d& anchor_A_m, Eigen::Vector3d& anchor_B_m, const char* description) {
  if (keys.has("anchors_m")) {
    const std::array anchors{&anchor_A_m, &anchor_B_m};
    if (keys.size("anchors_m") != anchors.size())
      return keys.reject("anchors_m", "needs two vectors (one per body). Write [[x, y, z], [x, y, z]].");
    const Value both = *keys.raw("anchors_m");
    for (std::size_t end = 0; end < anchors.size(); ++end) {
      // A list in a list has no keys, so the position of each anchor serves as its key.
      const std::string key = std::to_string(end);
      const Value wrapped{Value::Kind::mapping, {}, {}, {{key, {}, both.items[end]}}, {}};
      Keys(&wrapped, keys.path_of("anchors_m"), keys.problems()).numbers(required(key.c_str()), *anchors[end], "");
    }
  }
  keys.write("anchors_m", ordered_json::array({anchor_A_m, anchor_B_m}));
  keys.describe("anchors_m", schema_of_list(schema_of_list(schema_of_number(Range::any), 3), 2), description);
}

void declare_orientation(Keys& keys, Eigen::Vector4d& q, const char* description) {
  keys.numbers("orientation_wxyz", q, description);
  if (!keys.reads()) return;
  const double norm = q.norm();
  if (std::abs(norm - 1.0) < 1e-15) return;
  if (std::abs(norm - 1.0) < 1e-3) {
    q = q / norm;
    return;
  }
  keys.reject("orientation_wxyz",
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

void declare(Keys& keys, SingleBody& body, double step_s) {
  keys.name(required("name"), body.name, "Unique name.");
  declare(keys, body.shape);
  declare_mass(keys, body);
  keys.numbers(required("position_m"), body.position_m,
               "Place of the shape's own frame at the start [m]: of its centre, but for meshes and compounds.");
  declare_orientation(keys, body.orientation_wxyz,
                      "Orientation at the start: unit quaternion. Capsules and cylinders lie along their own z axis.");
  const bool is_section = has_prescribed_motion(keys, body);
  if (keys.when(!is_section)) {
    keys.numbers("velocity_m_per_s", body.velocity_m_per_s, "Velocity of the centre of mass at the start.");
    keys.numbers("angular_velocity_rad_per_s", body.angular_velocity_rad_per_s,
                 "Angular velocity at the start, world frame.");
    keys.choice("motion", body.motion, motion_names,
                "free; fixed: never moves; prescribed: keeps its velocities; axis: moves along and rotates about "
                "`axis` only; {prescribed: …}: moves as a function of time.");
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

void declare(Keys& keys, NamedJoint& joint, double step_s) {
  keys.name(required("name"), joint.name, "Name of the joint.");
  joint.bodies.resize(2);
  if (!keys.kind(joint.kind, joint_names,
                 "ball: one point in common; hinge: and an axis; slider: moves along an axis without turning; fixed: "
                 "no relative motion; distance: a rod without mass; model: as body.model has it, in resolved cases."))
    return;
  declare_names(keys, required("bodies"), joint.bodies, 2, "a joint has two). Write bodies: [a, b], or [a, world].",
                "Names of the two bodies, or of a body and world.");
  if (!keys.when(joint.kind != JointKind::model)) return;
  if (keys.when(joint.kind == JointKind::distance))
    declare_anchors(keys, joint.anchor_A_m, joint.anchor_B_m,
                    "For distance: ends of the rod in the frame of each body, relative to its centre; in the world a "
                    "place. Default: the centres.");
  if (keys.when(joint.kind != JointKind::distance))
    keys.numbers(keys.needed("anchor_m"), joint.anchor_m,
                 "The point in common at the start, in the world. Not for distance.");
  if (keys.when(has_axis(joint.kind)))
    declare_direction(keys, keys.needed("axis"), joint.axis,
                      "Direction of the axis at the start, in the world. For hinge and slider.");
  if (keys.when(joint.kind == JointKind::hinge))
    declare_motion(keys, joint, {"stiffness_N_m_per_rad", "Of a spring in a hinge."},
                   {"damping_N_m_s_per_rad", "Of a damper in a hinge."},
                   {"rest_rad",
                    "Angle from the start at which the spring of a hinge is relaxed, of the first body relative to the "
                    "second; within half a turn."},
                   {"limits_rad",
                    "Lowest and highest angle of a hinge from the start, of the first body relative to the second; "
                    "between -3 and 3. A stop takes the motion up. Default: no limits."});
  if (keys.when(joint.kind == JointKind::slider))
    declare_motion(keys, joint, {"stiffness_N_per_m", "Of a spring along a slider."},
                   {"damping_N_s_per_m", "Of a damper along a slider."},
                   {"rest_m", "Motion from the start at which the spring of a slider is relaxed."},
                   {"limits_m",
                    "Lowest and highest motion of a slider from the start. A stop takes the motion up. Default: no "
                    "limits."});
  if (!keys.when(has_motion(joint.kind))) return;
  const bool turns = joint.kind == JointKind::hinge;
  keys.section<Signal>("signal", joint.signal,
                       "How a hinge, slider or rod moves, the first body relative to the second: what it has turned "
                       "[rad] or moved [m] is the signal less its value at the start. Default: it moves freely.",
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
  keys.reject_if(distinct.empty() || distinct.size() != group.bodies.size(), "bodies",
                 "is empty or names a body twice (its motion is that of its bodies). List each once.");
  declare_direction(keys, "axis", group.axis, "Own axis at the start, in the world; it is carried along.");
  keys.integer("period_steps", group.period_steps, Range::not_negative,
               "Period of the cycles. Default: 0, that of what drives the bodies.");
}

}  // namespace copepod::coupler
