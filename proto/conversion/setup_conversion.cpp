
#include <algorithm>
#include <array>
#include <concepts>
#include <ranges>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include <google/protobuf/util/json_util.h>

#include "conversion/arrays.hpp"
#include "conversion/codec.hpp"
#include "conversion/enumerations.hpp"
#include "conversion/limits.hpp"
#include "conversion/message_fields.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using session::Header;
using session::Hello;
using session::MessageKind;
using session::Refusal;
using session::Saved;
using session::Welcome;

constexpr std::array kFailures = {ExitCode::bad_case,      ExitCode::refused,        ExitCode::component_lost,
                                  ExitCode::solver_failed, ExitCode::storage_failed, ExitCode::deadline_passed,
                                  ExitCode::interrupted,   ExitCode::terminated};

const FieldDescriptor* field_of(const Message& message, const char* name) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
  if (field == nullptr) throw std::logic_error(message.GetTypeName() + " has no field " + name);
  return field;
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
  void put(const FieldDescriptor* field, bool value) {
    field->is_repeated() ? reflection_->AddBool(message_, field, value) : reflection_->SetBool(message_, field, value);
  }
  void put(const FieldDescriptor* field, std::uint64_t value) { reflection_->SetUInt64(message_, field, value); }
  void put(const FieldDescriptor* field, std::uint32_t value) { reflection_->SetUInt32(message_, field, value); }
  void put(const FieldDescriptor* field, int value) {
    field->cpp_type() == FieldDescriptor::CPPTYPE_INT32
        ? reflection_->SetInt32(message_, field, value)
        : reflection_->SetUInt32(message_, field, static_cast<std::uint32_t>(value));
  }
  void put(const FieldDescriptor* field, ExitCode code) { put(field, static_cast<int>(code)); }
  template <class T>
  void put(const FieldDescriptor* field, const std::optional<T>& value) {
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
    value =
        field->is_repeated() ? reflection_.GetRepeatedBool(message_, field, i) : reflection_.GetBool(message_, field);
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
  template <class T>
  void get(const FieldDescriptor* field, int i, std::optional<T>& value) const {
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
    fit(field, list, size);
    int i = 0;
    for (auto& value : list) get(field, i++, value);
  }
  void get(const FieldDescriptor* field, int, std::set<std::string>& names) const {
    const int size = reflection_.FieldSize(message_, field);
    require_at_most(size, kLimits.features, (path_ + field->name()).c_str());
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

/// @throws MalformedMessage if a corner is none of the vertices
Mesh read_mesh(const v1::TriangleMesh& wire) {
  const auto& numbers = wire.vertices_m();
  const auto& corners = wire.triangles();
  const int vertices = numbers.size() / 3;
  if (numbers.size() % 3 != 0 || corners.size() % 3 != 0 || corners.empty() ||
      !all_finite(numbers.data(), numbers.size()) ||
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
  write_message(setup, wire);
  return wire.SerializeAsString();
}

template <class Wire, class Setup>
std::string json_of(const Setup& setup) {
  Wire wire;
  write_message(setup, wire);
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = options.always_print_primitive_fields = true;
  std::string text;
  if (!MessageToJsonString(wire, &text, options).ok()) throw MalformedMessage("a text of the setup is not UTF-8");
  return text;
}

template <class Wire, class Setup>
Setup setup_from(std::string_view bytes) {
  Wire wire;
  if (bytes.size() > kLimits.message_bytes || !wire.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    throw MalformedMessage("the bytes are not a " + wire.GetTypeName());
  Setup setup;
  read_message(wire, setup);
  return setup;
}

}  // namespace

std::string to_bytes(const FluidSetup& setup) { return bytes_of<v1::FluidSetup>(setup); }
std::string to_bytes(const BodySetup& setup) { return bytes_of<v1::BodySetup>(setup); }

std::string to_json(const FluidSetup& setup) { return json_of<v1::FluidSetup>(setup); }
std::string to_json(const BodySetup& setup) { return json_of<v1::BodySetup>(setup); }

FluidSetup fluid_setup_from_bytes(std::string_view bytes) { return setup_from<v1::FluidSetup, FluidSetup>(bytes); }
BodySetup body_setup_from_bytes(std::string_view bytes) { return setup_from<v1::BodySetup, BodySetup>(bytes); }

// As bodies of an Envelope.

template <class Struct>
Bytes Encoder::put(const Header& header, MessageKind kind, const Struct& sent) {
  write_message(sent, body(kind));
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const Hello& sent) { return put(header, MessageKind::hello, sent); }
Bytes Encoder::encode(const Header& header, const Welcome& sent) { return put(header, MessageKind::welcome, sent); }
Bytes Encoder::encode(const Header& header, const Refusal& sent) { return put(header, MessageKind::refusal, sent); }
Bytes Encoder::encode(const Header& header, const FluidSetup& sent) {
  return put(header, MessageKind::fluid_setup, sent);
}
Bytes Encoder::encode(const Header& header, const BodySetup& sent) {
  return put(header, MessageKind::body_setup, sent);
}
Bytes Encoder::encode(const Header& header, const ControllerSetup& sent) {
  return put(header, MessageKind::controller_setup, sent);
}
Bytes Encoder::encode(const Header& header, const session::Ping& sent) { return put(header, MessageKind::ping, sent); }
Bytes Encoder::encode(const Header& header, const session::Pong& sent) {
  return put(header.at(sent.step), MessageKind::pong, sent);
}
Bytes Encoder::encode(const Header& header, const Saved& sent) { return put(header, MessageKind::saved, sent); }
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

void Decoder::read(Hello& hello) const { read_message(envelope().hello(), hello); }
void Decoder::read(Welcome& welcome) const { read_message(envelope().welcome(), welcome); }
void Decoder::read(Refusal& refusal) const { read_message(envelope().refusal(), refusal); }
void Decoder::read(FluidSetup& setup) const { read_message(envelope().fluid_setup(), setup); }
void Decoder::read(BodySetup& setup) const { read_message(envelope().body_setup(), setup); }
void Decoder::read(ControllerSetup& setup) const { read_message(envelope().controller_setup(), setup); }
void Decoder::read(session::Ping& ping) const { read_message(envelope().ping(), ping); }
void Decoder::read(session::Pong& pong) const { read_message(envelope().pong(), pong); }
void Decoder::read(Saved& saved) const { read_message(envelope().saved(), saved); }

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
    require_finite(&seconds, 1, "seconds");
    summary.seconds[phase] = seconds;
  }
}

}  // namespace copepod::conversion
