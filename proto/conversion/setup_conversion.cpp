
#include <algorithm>
#include <array>
#include <concepts>
#include <ranges>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "conversion/arrays.hpp"
#include "conversion/codec.hpp"
#include "conversion/enumerations.hpp"
#include "conversion/limits.hpp"
#include "conversion/text.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using session::Header;
using session::MessageKind;

// The one description of each message without arrays: `describe` hands each field's name and value to a Writer or a
// Reader, which treat it by its type.

/// A contract struct, constant where it is only read.
template <class T, class Struct>
concept Is = std::same_as<std::remove_const_t<T>, Struct>;

constexpr std::array kFailures = {ExitCode::bad_case,      ExitCode::refused,        ExitCode::component_lost,
                                  ExitCode::solver_failed, ExitCode::storage_failed, ExitCode::deadline_passed,
                                  ExitCode::interrupted,   ExitCode::terminated};

const FieldDescriptor* field_of(const Message& message, const char* name) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
  if (field == nullptr) throw std::logic_error(message.GetTypeName() + " has no field " + name);
  return field;
}

/// Of a text for people, from anywhere: what cannot travel is left out.
constexpr struct Prose {
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
}

void describe(auto& wire, Is<Boundary> auto& boundary) {
  wire("kind", boundary.kind);
  wire("velocity_m_per_s", boundary.velocity_m_per_s);
  wire("pressure_Pa", boundary.pressure_Pa);
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

template <class T>
concept List = std::ranges::range<T> && !std::same_as<T, std::string>;

template <class T>
concept Enumeration = std::is_enum_v<T>;

template <class T>
concept Record = std::is_class_v<T> && !std::ranges::range<T> && !std::same_as<T, std::shared_ptr<const TriangleMesh>>;

/// The meshes of a setup: a shape on the wire has the number of its own, so that each goes over once.
using Mesh = std::shared_ptr<const TriangleMesh>;
using Meshes = std::vector<Mesh>;

/// Contract struct -> message. What is written under a repeated field is appended to it.
class Writer {
 public:
  Writer(Message& message, Meshes& meshes)
      : message_(&message), reflection_(message.GetReflection()), meshes_(meshes) {}

  template <class T>
  void operator()(const char* name, const T& value) {
    put(field_of(*message_, name), value);
  }
  /// @param first  least value of an index, 0 on the wire
  void operator()(const char* name, int index, int first) { (*this)(name, index - first); }
  void operator()(const char* name, const std::string& text, std::size_t /*most_bytes*/) { (*this)(name, text); }
  void operator()(const char* name, const std::string& text, Prose /*unused*/) {
    (*this)(name, as_utf8(text, kLimits.string_bytes));
  }

 private:
  // One function for each type of value.
  void put(const FieldDescriptor* field, double value) {
    field->is_repeated() ? reflection_->AddDouble(message_, field, value)
                         : reflection_->SetDouble(message_, field, value);
  }
  void put(const FieldDescriptor* field, std::int64_t value) {
    field->is_repeated() ? reflection_->AddInt64(message_, field, value)
                         : reflection_->SetInt64(message_, field, value);
  }
  void put(const FieldDescriptor* field, bool value) { reflection_->AddBool(message_, field, value); }
  void put(const FieldDescriptor* field, std::uint64_t value) { reflection_->SetUInt64(message_, field, value); }
  void put(const FieldDescriptor* field, std::uint32_t value) { reflection_->SetUInt32(message_, field, value); }
  void put(const FieldDescriptor* field, int value) {
    field->cpp_type() == FieldDescriptor::CPPTYPE_INT32
        ? reflection_->SetInt32(message_, field, value)
        : reflection_->SetUInt32(message_, field, static_cast<std::uint32_t>(value));
  }
  void put(const FieldDescriptor* field, ExitCode code) { put(field, static_cast<int>(code)); }
  void put(const FieldDescriptor* field, const std::optional<double>& value) {
    if (value) put(field, *value);
  }
  void put(const FieldDescriptor* field, const std::string& text) {
    field->is_repeated() ? reflection_->AddString(message_, field, text)
                         : reflection_->SetString(message_, field, text);
  }
  void put(const FieldDescriptor* field, Enumeration auto value) {
    field->is_repeated() ? reflection_->AddEnumValue(message_, field, to_wire<int>(value))
                         : reflection_->SetEnumValue(message_, field, to_wire<int>(value));
  }
  void put(const FieldDescriptor* field, const List auto& list) {
    for (const auto& value : list) put(field, value);
  }
  void put(const FieldDescriptor* field, const Record auto& value) {
    Writer inner(field->is_repeated() ? *reflection_->AddMessage(message_, field)
                                      : *reflection_->MutableMessage(message_, field),
                 meshes_);
    describe(inner, value);
  }
  void put(const FieldDescriptor* field, const Mesh& mesh) {
    const auto known = std::ranges::find_if(meshes_, [&](const Mesh& written) { return *written == *mesh; });
    put(field, static_cast<int>(known - meshes_.begin()) + 1);
    if (known == meshes_.end()) meshes_.push_back(mesh);
  }

  Message* message_;
  const Reflection* reflection_;
  Meshes& meshes_;  ///< written so far
};

// What the fields of a message must fulfil together.

void check(const auto& /*other messages*/) {}

void check(const Shape& shape) {
  const bool has_extents = shape.kind == ShapeKind::ellipsoid || shape.kind == ShapeKind::box;
  if (!(shape.radius_m > 0.0) || shape.length_m < 0.0 || (has_extents && !(shape.extents_m.minCoeff() > 0.0)))
    throw MalformedMessage("a shape has an extent that is not positive");
  if (shape.kind == ShapeKind::compound && shape.parts.empty()) throw MalformedMessage("a compound has no parts");
}

void check(const ShapePart& part) {
  if (part.shape.kind == ShapeKind::compound) throw MalformedMessage("a part of a compound is a compound itself");
}

void check(const BodySpecification& body) {
  if (!body.inertia_kg_m2.empty() && body.inertia_kg_m2.size() != 6)
    throw MalformedMessage("inertia_kg_m2 has " + std::to_string(body.inertia_kg_m2.size()) + " entries, not 6");
}

/// Message -> contract struct; throws MalformedMessage naming the field.
class Reader {
 public:
  Reader(const Message& message, const Meshes& meshes, std::string path)
      : message_(message), reflection_(*message.GetReflection()), meshes_(meshes), path_(std::move(path)) {}

  template <class T>
  void operator()(const char* name, T& value) {
    get(field_of(message_, name), 0, value);
  }
  /// @param first  least value of an index, 0 on the wire
  void operator()(const char* name, int& index, int first) {
    (*this)(name, index);
    index += first;
  }
  void operator()(const char* name, std::string& text, std::size_t most_bytes) {
    text = reflection_.GetString(message_, field_of(message_, name));
    require_at_most(text.size(), most_bytes, (path_ + name).c_str());
  }
  void operator()(const char* name, std::string& text, Prose /*unused*/) { (*this)(name, text); }

 private:
  // One function for each type of value; `i` is its place in a repeated field.
  void get(const FieldDescriptor* field, int i, double& value) const {
    value = field->is_repeated() ? reflection_.GetRepeatedDouble(message_, field, i)
                                 : reflection_.GetDouble(message_, field);
    require_finite(&value, 1, (path_ + field->name()).c_str());
  }
  void get(const FieldDescriptor* field, int i, std::int64_t& value) const {
    value =
        field->is_repeated() ? reflection_.GetRepeatedInt64(message_, field, i) : reflection_.GetInt64(message_, field);
    if (value < 0 && field->type() != FieldDescriptor::TYPE_SINT64)
      fail(field, "is " + std::to_string(value) + ", less than 0");
  }
  void get(const FieldDescriptor* field, int i, bool& value) const {
    value = reflection_.GetRepeatedBool(message_, field, i);
  }
  void get(const FieldDescriptor* field, int, std::uint64_t& value) const {
    value = reflection_.GetUInt64(message_, field);
  }
  void get(const FieldDescriptor* field, int, std::uint32_t& value) const {
    value = reflection_.GetUInt32(message_, field);
  }
  void get(const FieldDescriptor* field, int, int& index) const {
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_INT32) {
      index = reflection_.GetInt32(message_, field);
      return;
    }
    const std::uint32_t number = reflection_.GetUInt32(message_, field);
    if (!std::in_range<int>(number)) fail(field, "is " + std::to_string(number));
    index = static_cast<int>(number);
  }
  void get(const FieldDescriptor* field, int i, ExitCode& code) const {
    int number = 0;
    get(field, i, number);
    // Codes of other builds must not turn into nonsense, nor a failure into success.
    const bool is_known = std::ranges::count(kFailures, static_cast<ExitCode>(number)) > 0;
    code = is_known ? static_cast<ExitCode>(number) : ExitCode::solver_failed;
  }
  void get(const FieldDescriptor* field, int i, std::optional<double>& value) const {
    value.reset();
    if (reflection_.HasField(message_, field)) get(field, i, value.emplace());
  }
  void get(const FieldDescriptor* field, int i, std::string& text) const {
    text = field->is_repeated() ? reflection_.GetRepeatedString(message_, field, i)
                                : reflection_.GetString(message_, field);
    require_at_most(text.size(), kLimits.string_bytes, (path_ + field->name()).c_str());
  }
  void get(const FieldDescriptor* field, int i, Enumeration auto& value) const {
    const std::string name = path_ + field->name();
    const int number = field->is_repeated() ? reflection_.GetRepeatedEnumValue(message_, field, i)
                                            : reflection_.GetEnumValue(message_, field);
    value = from_wire<std::remove_reference_t<decltype(value)>>(number, *field->enum_type(), name.c_str());
  }
  void get(const FieldDescriptor* field, int, List auto& list) const {
    const int size = reflection_.FieldSize(message_, field);
    fit(field, list, static_cast<std::size_t>(size));
    int i = 0;
    for (auto& value : list) get(field, i++, value);
  }
  void get(const FieldDescriptor* field, int, std::set<std::string>& names) const {
    const int size = reflection_.FieldSize(message_, field);
    require_at_most(static_cast<std::size_t>(size), kLimits.features, (path_ + field->name()).c_str());
    names.clear();
    std::string name;
    for (int i = 0; i < size; ++i) {
      get(field, i, name);
      names.insert(name);
    }
  }
  void get(const FieldDescriptor* field, int i, Record auto& value) const {
    Reader inner(field->is_repeated() ? reflection_.GetRepeatedMessage(message_, field, i)
                                      : reflection_.GetMessage(message_, field),
                 meshes_, path_ + field->name() + ".");
    describe(inner, value);
    check(value);
  }
  void get(const FieldDescriptor* field, int, Mesh& mesh) const {
    const std::uint32_t number = reflection_.GetUInt32(message_, field);
    if (number == 0 || number > meshes_.size())
      fail(field, "is " + std::to_string(number) + " of " + std::to_string(meshes_.size()));
    mesh = meshes_[number - 1];
  }

  template <class T>
  void fit(const FieldDescriptor* field, std::vector<T>& list, std::size_t size) const {
    require_at_most(size, kLimits.list_entries, (path_ + field->name()).c_str());
    list.assign(size, T{});
  }
  void fit(const FieldDescriptor* field, const auto& array, std::size_t size) const {
    const auto length = static_cast<std::size_t>(array.size());
    if (size != length) fail(field, "has " + std::to_string(size) + " entries, not " + std::to_string(length));
  }
  [[noreturn]] void fail(const FieldDescriptor* field, const std::string& problem) const {
    throw MalformedMessage(path_ + field->name() + " " + problem);
  }

  const Message& message_;
  const Reflection& reflection_;
  const Meshes& meshes_;  ///< of the setup
  std::string path_;      ///< before a field's name in messages: "fields."
};

void check(const FieldOutput& fields) {
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

void check(const FluidSetup& setup) {
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
  check(setup.fields);
}

void check(const BodySetup& setup) {
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

/// @throws MalformedMessage if a corner is none of the vertices
Mesh read_mesh(const v1::TriangleMesh& wire) {
  const auto& numbers = wire.vertices_m();
  const auto& corners = wire.triangles();
  const int vertices = numbers.size() / 3;
  if (numbers.size() % 3 != 0 || corners.size() % 3 != 0 || corners.empty() ||
      !all_finite(numbers.data(), static_cast<std::size_t>(numbers.size())) ||
      std::ranges::any_of(corners, [&](std::uint32_t corner) { return std::cmp_greater_equal(corner, vertices); }))
    throw MalformedMessage("a mesh has a vertex that is not finite, or a triangle without three vertices");
  TriangleMesh::Triangles triangles(3, corners.size() / 3);
  std::ranges::copy(corners, triangles.data());
  return std::make_shared<const TriangleMesh>(Eigen::Map<const Eigen::Matrix3Xd>(numbers.data(), 3, vertices),
                                              std::move(triangles));
}

/// The meshes of a message are in a field of its own.
template <class Struct>
void write_message(const Struct& value, Message& wire) {
  wire.Clear();
  Meshes meshes;
  Writer writer(wire, meshes);
  describe(writer, value);
  for (const Mesh& mesh : meshes) {
    auto& written = static_cast<v1::TriangleMesh&>(*wire.GetReflection()->AddMessage(&wire, field_of(wire, "meshes")));
    written.mutable_vertices_m()->Add(mesh->vertices_m.data(), mesh->vertices_m.data() + mesh->vertices_m.size());
    written.mutable_triangles()->Add(mesh->triangles.data(), mesh->triangles.data() + mesh->triangles.size());
  }
}

template <class Struct>
void read_message(const Message& wire, Struct& value) {
  Meshes meshes;
  const Reflection& reflection = *wire.GetReflection();
  const FieldDescriptor* const field = wire.GetDescriptor()->FindFieldByName("meshes");
  for (int i = 0; field != nullptr && i < reflection.FieldSize(wire, field); ++i)
    meshes.push_back(read_mesh(static_cast<const v1::TriangleMesh&>(reflection.GetRepeatedMessage(wire, field, i))));
  Reader reader(wire, meshes, "");
  describe(reader, value);
  check(value);
}

template <class Wire, class Setup>
std::string bytes_of(const Setup& setup) {
  Wire wire;
  write(setup, wire);
  return wire.SerializeAsString();
}

template <class Wire, class Setup>
Setup setup_from(std::string_view bytes) {
  Wire wire;
  if (bytes.size() > kLimits.message_bytes || !wire.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    throw MalformedMessage("the bytes are not a " + wire.GetTypeName());
  Setup setup;
  read(wire, setup);
  return setup;
}

}  // namespace

void write(const FluidSetup& setup, v1::FluidSetup& wire) { write_message(setup, wire); }
void write(const BodySetup& setup, v1::BodySetup& wire) { write_message(setup, wire); }
void read(const v1::FluidSetup& wire, FluidSetup& setup) { read_message(wire, setup); }
void read(const v1::BodySetup& wire, BodySetup& setup) { read_message(wire, setup); }

std::string to_bytes(const FluidSetup& setup) { return bytes_of<v1::FluidSetup>(setup); }
std::string to_bytes(const BodySetup& setup) { return bytes_of<v1::BodySetup>(setup); }

FluidSetup fluid_setup_from_bytes(std::string_view bytes) { return setup_from<v1::FluidSetup, FluidSetup>(bytes); }
BodySetup body_setup_from_bytes(std::string_view bytes) { return setup_from<v1::BodySetup, BodySetup>(bytes); }

// As bodies of an Envelope.

template <class Struct>
Bytes Encoder::put(const Header& header, MessageKind kind, const Struct& sent) {
  write_message(sent, body(kind));
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const session::Hello& sent) {
  return put(header, MessageKind::hello, sent);
}
Bytes Encoder::encode(const Header& header, const session::Welcome& sent) {
  return put(header, MessageKind::welcome, sent);
}
Bytes Encoder::encode(const Header& header, const session::Refusal& sent) {
  return put(header, MessageKind::refusal, sent);
}
Bytes Encoder::encode(const Header& header, const FluidSetup& sent) {
  return put(header, MessageKind::fluid_setup, sent);
}
Bytes Encoder::encode(const Header& header, const BodySetup& sent) {
  return put(header, MessageKind::body_setup, sent);
}
Bytes Encoder::encode(const Header& header, const session::Ping& sent) { return put(header, MessageKind::ping, sent); }
Bytes Encoder::encode(const Header& header, const session::Pong& sent) {
  return put(header.at(sent.step), MessageKind::pong, sent);
}
Bytes Encoder::encode(const Header& header, const session::Saved& sent) {
  return put(header, MessageKind::saved, sent);
}
Bytes Encoder::encode(const Header& header, const FailureReport& sent) {
  return put(header.at(sent.step), MessageKind::failure, sent);
}

Bytes Encoder::encode_abort(const Header& header, const FailureReport& failure) {
  write_message(failure, *static_cast<v1::Abort&>(body(MessageKind::abort)).mutable_failure());
  return serialise(header.at(failure.step));
}

Bytes Encoder::encode(const Header& header, MessageKind kind, const session::CheckpointPath& path) {
  require_at_most(path.path.size(), kLimits.string_bytes, "the path");
  return put(header, kind, path);
}

Bytes Encoder::encode(const Header& header, const SolverSummary& summary) {
  auto& wire = static_cast<v1::Summary&>(body(MessageKind::summary));
  write_message(summary, wire);
  for (const auto& [phase, seconds] : summary.seconds) (*wire.mutable_seconds())[phase] = seconds;
  return serialise(header);
}

void Decoder::read(session::Hello& hello) const { read_message(envelope().hello(), hello); }
void Decoder::read(session::Welcome& welcome) const { read_message(envelope().welcome(), welcome); }
void Decoder::read(session::Refusal& refusal) const { read_message(envelope().refusal(), refusal); }
void Decoder::read(FluidSetup& setup) const { read_message(envelope().fluid_setup(), setup); }
void Decoder::read(BodySetup& setup) const { read_message(envelope().body_setup(), setup); }
void Decoder::read(session::Ping& ping) const { read_message(envelope().ping(), ping); }
void Decoder::read(session::Pong& pong) const { read_message(envelope().pong(), pong); }
void Decoder::read(session::Saved& saved) const { read_message(envelope().saved(), saved); }

void Decoder::read(session::CheckpointPath& path) const {
  kind() == MessageKind::save ? read_message(envelope().save(), path) : read_message(envelope().restore(), path);
}

void Decoder::read(FailureReport& failure) const {
  read_message(kind() == MessageKind::abort ? envelope().abort().failure() : envelope().failure(), failure);
}

void Decoder::read(SolverSummary& summary) const {
  const v1::Summary& wire = envelope().summary();
  read_message(wire, summary);
  require_at_most(wire.seconds().size(), kLimits.features, "seconds");
  summary.seconds.clear();
  for (const auto& [phase, seconds] : wire.seconds()) {
    require_at_most(phase.size(), kLimits.string_bytes, "phase");
    summary.seconds[phase] = read_finite(seconds, "seconds");
  }
}

}  // namespace copepod::conversion
