#include "conversion/setup_conversion.hpp"

#include <algorithm>
#include <stdexcept>
#include <type_traits>

#include "contract/words.hpp"
#include "conversion/arrays.hpp"
#include "conversion/decoder.hpp"
#include "conversion/encoder.hpp"
#include "conversion/enumerations.hpp"
#include "conversion/limits.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

const FieldDescriptor* field_of(const Message& message, const char* name) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
  if (field == nullptr) throw std::logic_error(message.GetTypeName() + " has no field " + name);
  return field;
}

// The one description of each setup message: `describe` hands each field's name and value to a Writer or a
// Reader. The words of an enumerator bound its values; indices are shifted so that −1 becomes 0 on the wire.

/// The contract struct that a wire of type Wire fills or only reads.
template <class Wire, class T>
using Struct = std::conditional_t<Wire::fills, T, const T>;

template <class Wire>
void describe(Wire& wire, Struct<Wire, Shape>& shape) {
  wire.choice("kind", shape.kind, shape_names);
  wire.scalar("radius_m", shape.radius_m);
  wire.scalar("length_m", shape.length_m);
}

template <class Wire>
void describe(Wire& wire, Struct<Wire, Boundary>& boundary) {
  wire.choice("kind", boundary.kind, boundary_names);
  wire.array("velocity_m_per_s", boundary.velocity_m_per_s);
  wire.scalar("pressure_Pa", boundary.pressure_Pa);
}

template <class Wire>
void describe(Wire& wire, Struct<Wire, FieldOutput>& fields) {
  wire.scalar("directory", fields.directory);
  wire.scalar("every_steps", fields.every_steps);
  wire.scalar("mean_start", fields.mean_start);
  wire.scalar("mean_stop", fields.mean_stop);
  wire.scalar("mean_every_steps", fields.mean_every_steps);
}

template <class Wire>
void describe(Wire& wire, Struct<Wire, FluidSetup>& setup) {
  wire.choice("kind", setup.kind, fluid_kind_names);
  wire.scalar("step_s", setup.step_s);
  wire.scalar("cell_size_m", setup.cell_size_m);
  wire.scalar("density_kg_per_m3", setup.density_kg_per_m3);
  wire.scalar("kinematic_viscosity_m2_per_s", setup.kinematic_viscosity_m2_per_s);
  wire.array("domain_cells", setup.domain_cells);
  wire.messages("boundaries", setup.boundaries);
  wire.index("no_slip_plane", setup.no_slip_plane, 1);
  wire.array("symmetry_planes", setup.symmetry_planes);
  wire.array("body_force_N_per_m3", setup.body_force_N_per_m3);
  wire.choice("collision", setup.collision, collision_names);
  wire.choice("moving_boundary", setup.moving_boundary, moving_boundary_names);
  wire.choice("refill", setup.refill, refill_names);
  wire.choice("precision", setup.precision, precision_names);
  wire.messages("bodies", setup.bodies, kLimits.bodies);
  wire.message("fields", setup.fields);
  wire.scalar("trace_directory", setup.trace_directory);
}

template <class Wire>
void describe(Wire& wire, Struct<Wire, BodySpecification>& body) {
  wire.scalar("name", body.name);
  wire.message("shape", body.shape);
  wire.scalar("mass_kg", body.mass_kg);
  wire.choice("motion", body.motion, motion_names);
  wire.array("axis", body.axis);
  wire.array("position_m", body.position_m);
  wire.array("orientation_wxyz", body.orientation_wxyz);
  wire.array("velocity_m_per_s", body.velocity_m_per_s);
  wire.array("angular_velocity_rad_per_s", body.angular_velocity_rad_per_s);
}

template <class Wire>
void describe(Wire& wire, Struct<Wire, SpringSpecification>& spring) {
  wire.index("body_A", spring.body_A, 0);
  wire.index("body_B", spring.body_B, 0);
  wire.scalar("stiffness_N_per_m", spring.stiffness_N_per_m);
  wire.scalar("damping_N_s_per_m", spring.damping_N_s_per_m);
  wire.scalar("rest_length_m", spring.rest_length_m);
  wire.array("anchor_A_m", spring.anchor_A_m);
  wire.array("anchor_B_m", spring.anchor_B_m);
}

template <class Wire>
void describe(Wire& wire, Struct<Wire, BodySetup>& setup) {
  wire.scalar("step_s", setup.step_s);
  wire.choice("integrator", setup.integrator, integrator_names);
  wire.array("gravity_m_per_s2", setup.gravity_m_per_s2);
  wire.scalar("fluid_density_kg_per_m3", setup.fluid_density_kg_per_m3);
  wire.array("periodic_length_m", setup.periodic_length_m);
  wire.messages("bodies", setup.bodies, kLimits.bodies);
  wire.messages("springs", setup.springs, kLimits.springs);
  wire.scalar("trace_directory", setup.trace_directory);
}

/// Contract struct -> message.
class Writer {
 public:
  static constexpr bool fills = false;
  explicit Writer(Message& message) : message_(message), reflection_(*message.GetReflection()) {}

  void scalar(const char* name, double value) { reflection_.SetDouble(&message_, field(name), value); }
  void scalar(const char* name, std::int64_t value) { reflection_.SetInt64(&message_, field(name), value); }
  void scalar(const char* name, const std::string& text) { reflection_.SetString(&message_, field(name), text); }
  template <class E, std::size_t N>
  void choice(const char* name, E value, const std::array<Choice<E>, N>&) {
    reflection_.SetEnumValue(&message_, field(name), to_wire<int>(value));
  }
  void index(const char* name, int value, int shift) {
    reflection_.SetUInt32(&message_, field(name), static_cast<std::uint32_t>(value + shift));
  }
  template <class Array>
  void array(const char* name, const Array& values) {
    const FieldDescriptor* target = field(name);
    for (const auto value : values) add(target, value);
  }
  template <class T>
  void message(const char* name, const T& value) {
    Writer inner(*reflection_.MutableMessage(&message_, field(name)));
    describe(inner, value);
  }
  template <class List>
  void messages(const char* name, const List& list, std::size_t = 0) {
    const FieldDescriptor* target = field(name);
    for (const auto& item : list) {
      Writer inner(*reflection_.AddMessage(&message_, target));
      describe(inner, item);
    }
  }

 private:
  [[nodiscard]] const FieldDescriptor* field(const char* name) const { return field_of(message_, name); }
  void add(const FieldDescriptor* target, double value) { reflection_.AddDouble(&message_, target, value); }
  void add(const FieldDescriptor* target, std::int64_t value) { reflection_.AddInt64(&message_, target, value); }
  void add(const FieldDescriptor* target, bool value) { reflection_.AddBool(&message_, target, value); }

  Message& message_;
  const Reflection& reflection_;
};

/// Message -> contract struct; throws MalformedMessage naming the field.
class Reader {
 public:
  static constexpr bool fills = true;
  Reader(const Message& message, std::string path)
      : message_(message), reflection_(*message.GetReflection()), path_(std::move(path)) {}

  void scalar(const char* name, double& value) {
    value = reflection_.GetDouble(message_, field(name));
    check(name, value);
  }
  void scalar(const char* name, std::int64_t& value) {
    value = reflection_.GetInt64(message_, field(name));
    check(name, value);
  }
  void scalar(const char* name, std::string& text) {
    text = reflection_.GetString(message_, field(name));
    require_at_most(text.size(), kLimits.string_bytes, (path_ + name).c_str());
  }
  template <class E, std::size_t N>
  void choice(const char* name, E& value, const std::array<Choice<E>, N>& words) {
    value = from_wire(reflection_.GetEnumValue(message_, field(name)), words.back().value, (path_ + name).c_str());
  }
  void index(const char* name, int& value, int shift) {
    const std::int64_t number = std::int64_t{reflection_.GetUInt32(message_, field(name))} - shift;
    if (number != static_cast<int>(number)) fail(name, "is " + std::to_string(number));
    value = static_cast<int>(number);
  }
  template <class Array>
  void array(const char* name, Array& values) {
    const FieldDescriptor* source = field(name);
    require_size(name, source, static_cast<int>(values.size()));
    int i = 0;
    for (auto& value : values) {
      get(source, i++, value);
      check(name, value);
    }
  }
  template <class T>
  void message(const char* name, T& value) {
    Reader inner(reflection_.GetMessage(message_, field(name)), path_ + name + ".");
    describe(inner, value);
  }
  template <class T, std::size_t N>
  void messages(const char* name, std::array<T, N>& items) {
    require_size(name, field(name), N);
    read_items(name, items);
  }
  template <class T>
  void messages(const char* name, std::vector<T>& items, std::size_t limit) {
    const auto size = static_cast<std::size_t>(reflection_.FieldSize(message_, field(name)));
    require_at_most(size, limit, (path_ + name).c_str());
    items.assign(size, T{});
    read_items(name, items);
  }

 private:
  [[nodiscard]] const FieldDescriptor* field(const char* name) const { return field_of(message_, name); }
  [[noreturn]] void fail(const char* name, const std::string& problem) const {
    throw MalformedMessage(path_ + name + " " + problem);
  }
  void check(const char* name, double value) const {
    if (!all_finite(&value, 1)) fail(name, "holds a number that is not finite");
  }
  void check(const char* name, std::int64_t count) const {
    if (count < 0) fail(name, "is " + std::to_string(count) + ", less than 0");
  }
  void check(const char*, bool) const {}
  void get(const FieldDescriptor* source, int i, double& value) const {
    value = reflection_.GetRepeatedDouble(message_, source, i);
  }
  void get(const FieldDescriptor* source, int i, std::int64_t& value) const {
    value = reflection_.GetRepeatedInt64(message_, source, i);
  }
  void get(const FieldDescriptor* source, int i, bool& value) const {
    value = reflection_.GetRepeatedBool(message_, source, i);
  }
  void require_size(const char* name, const FieldDescriptor* source, int size) const {
    const int found = reflection_.FieldSize(message_, source);
    if (found != size) fail(name, "has " + std::to_string(found) + " entries, not " + std::to_string(size));
  }
  template <class List>
  void read_items(const char* name, List& items) {
    const FieldDescriptor* source = field(name);
    int i = 0;
    for (auto& item : items) {
      Reader inner(reflection_.GetRepeatedMessage(message_, source, i++), path_ + name + ".");
      describe(inner, item);
    }
  }

  const Message& message_;
  const Reflection& reflection_;
  std::string path_;  ///< before a field's name in messages: "fields."
};

// What the fields of a setup must fulfil together.

void check(const FieldOutput& fields) {
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
  check(setup.fields);
}

void check(const BodySetup& setup) {
  const auto exists = [&](int body) { return static_cast<std::size_t>(body) < setup.bodies.size(); };
  for (const SpringSpecification& spring : setup.springs) {
    if (exists(spring.body_A) && exists(spring.body_B)) continue;
    throw MalformedMessage("a spring joins bodies " + std::to_string(spring.body_A) + " and " +
                           std::to_string(spring.body_B) + " of " + std::to_string(setup.bodies.size()));
  }
}

template <class Setup, class Wire>
void write_setup(const Setup& setup, Wire& wire) {
  wire.Clear();
  Writer writer(wire);
  describe(writer, setup);
}

template <class Setup, class Wire>
void read_setup(const Wire& wire, Setup& setup) {
  Reader reader(wire, "");
  describe(reader, setup);
  check(setup);
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

void write(const FluidSetup& setup, v1::FluidSetup& wire) { write_setup(setup, wire); }
void write(const BodySetup& setup, v1::BodySetup& wire) { write_setup(setup, wire); }
void read(const v1::FluidSetup& wire, FluidSetup& setup) { read_setup(wire, setup); }
void read(const v1::BodySetup& wire, BodySetup& setup) { read_setup(wire, setup); }

std::string to_bytes(const FluidSetup& setup) { return bytes_of<v1::FluidSetup>(setup); }
std::string to_bytes(const BodySetup& setup) { return bytes_of<v1::BodySetup>(setup); }

FluidSetup fluid_setup_from_bytes(std::string_view bytes) { return setup_from<v1::FluidSetup, FluidSetup>(bytes); }
BodySetup body_setup_from_bytes(std::string_view bytes) { return setup_from<v1::BodySetup, BodySetup>(bytes); }

// The setups as messages.

Bytes Encoder::encode(const session::Header& header, const FluidSetup& setup) {
  write(setup, *envelope().mutable_fluid_setup());
  return serialise(header);
}

Bytes Encoder::encode(const session::Header& header, const BodySetup& setup) {
  write(setup, *envelope().mutable_body_setup());
  return serialise(header);
}

void Decoder::read(FluidSetup& setup) const { conversion::read(envelope().fluid_setup(), setup); }
void Decoder::read(BodySetup& setup) const { conversion::read(envelope().body_setup(), setup); }

}  // namespace copepod::conversion
