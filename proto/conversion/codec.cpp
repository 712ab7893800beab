#include "conversion/codec.hpp"

#include <stdexcept>
#include <vector>

#include <google/protobuf/arena.h>
#include <google/protobuf/stubs/logging.h>

#include "conversion/arrays.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

namespace {

template <class Matrix>
std::span<const double> numbers_of(const Matrix& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}

Bytes bytes_of(const Doubles& field) {
  return std::as_bytes(std::span(field.data(), static_cast<std::size_t>(field.size())));
}

/// As many as `numbers` holds.
void read_numbers(Bytes bytes, const char* name, auto& numbers) {
  const auto count = static_cast<std::size_t>(numbers.size());
  require_length(bytes.size() / sizeof(double), count, name);
  if (!copy_finite(bytes.data(), count, numbers.data()))
    throw NotFinite(std::string(name) + " holds a number that is not finite");
}

/// The arrays of a message that Protobuf's parser has read.
std::array<Bytes, kMostArrays> arrays_of(const v1::Envelope& envelope) {
  const v1::Kinematics& kinematics = envelope.kinematics();
  const v1::Loads& loads = envelope.loads();
  const v1::AppliedLoads& applied = envelope.applied_loads();
  const v1::Observation& observation = envelope.observation();
  switch (envelope.body_case()) {
    case v1::Envelope::kKinematics:
      return {bytes_of(kinematics.position_m()), bytes_of(kinematics.orientation_wxyz()),
              bytes_of(kinematics.velocity_m_per_s()), bytes_of(kinematics.angular_velocity_rad_per_s())};
    case v1::Envelope::kObservation:
      return {bytes_of(observation.position_m()),
              bytes_of(observation.orientation_wxyz()),
              bytes_of(observation.velocity_m_per_s()),
              bytes_of(observation.angular_velocity_rad_per_s()),
              bytes_of(observation.force_n()),
              bytes_of(observation.torque_n_m()),
              bytes_of(observation.flow())};
    case v1::Envelope::kAction:
      return {bytes_of(envelope.action().value())};
    case v1::Envelope::kLoads:
      return {bytes_of(loads.force_n()), bytes_of(loads.torque_n_m()), bytes_of(loads.flow())};
    case v1::Envelope::kAppliedLoads:
      return {bytes_of(applied.force_n()), bytes_of(applied.torque_n_m()), bytes_of(applied.actuation())};
    default:
      return {};
  }
}

}  // namespace

using session::Header;
using session::MessageKind;

/// Header and body are written apart: the header ends where the body begins, whatever its length, so that a
/// message can be sent again with another header.
struct Encoder::Buffers {
  static constexpr std::size_t kLargestHead = 64;  ///< seven scalar fields with their tags

  v1::Envelope head;      ///< without a body
  v1::Envelope envelope;  ///< without a header; never cleared: the last message is overwritten in place
  std::vector<std::byte> bytes;
  std::size_t body_size = 0;

  /// Room for a body.
  std::byte* resize_body(std::size_t size) {
    require_at_most(size + kLargestHead + kChecksumBytes, kLimits.message_bytes, "the message");
    body_size = size;
    const std::size_t all = kLargestHead + size + kChecksumBytes;
    if (bytes.size() < all) bytes.resize(all);
    return bytes.data() + kLargestHead;
  }

  /// @return header, body and checksum
  Bytes finish() {
    const std::size_t head_size = head.ByteSizeLong();
    const auto message = std::span(bytes).subspan(kLargestHead - head_size, head_size + body_size + kChecksumBytes);
    head.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(message.data()));
    write_checksum(message);
    return message;
  }
};

Encoder::Encoder() : buffers_(std::make_unique<Buffers>()) {}
Encoder::~Encoder() = default;

google::protobuf::Message& Encoder::body(MessageKind kind) {
  v1::Envelope& envelope = buffers_->envelope;
  const auto* field = envelope.GetDescriptor()->FindFieldByNumber(static_cast<int>(kind));
  if (field == nullptr) throw std::logic_error(std::string(name_of(kind)) + " is not a message");
  return *envelope.GetReflection()->MutableMessage(&envelope, field);
}

Bytes Encoder::serialise(const Header& header) {
  const v1::Envelope& envelope = buffers_->envelope;
  std::byte* target = buffers_->resize_body(envelope.ByteSizeLong());
  envelope.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(target));
  return finish(header);
}

Bytes Encoder::serialise(const Header& header, int message, const Arrays& arrays) {
  write_arrays(message, arrays, buffers_->resize_body(size_of_arrays(message, arrays)));
  return finish(header);
}

Bytes Encoder::finish(const Header& header) {
  v1::Envelope& head = buffers_->head;
  head.set_protocol_major(header.protocol_major);
  head.set_protocol_minor(header.protocol_minor);
  head.set_session_id(header.session_id);
  head.set_epoch(header.epoch);
  head.set_sequence(header.sequence);
  head.set_attempt(header.attempt);
  head.set_step(header.step);
  return buffers_->finish();
}

Bytes Encoder::encode_again(std::uint32_t attempt) {
  buffers_->head.set_attempt(attempt);
  return buffers_->finish();
}

Bytes Encoder::encode(const Header& header, const session::Configured& configured) {
  const std::vector<double>& nodes = configured.driving_nodes;
  buffers_->envelope.mutable_configured()->mutable_driving_nodes()->Assign(nodes.begin(), nodes.end());
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const Kinematics& kinematics) {
  return serialise(header.at(kinematics.step), v1::Envelope::kKinematicsFieldNumber,
                   {numbers_of(kinematics.position_m), numbers_of(kinematics.orientation_wxyz),
                    numbers_of(kinematics.velocity_m_per_s), numbers_of(kinematics.angular_velocity_rad_per_s)});
}

Bytes Encoder::encode(const Header& header, const Loads& loads) {
  return serialise(header.at(loads.step), v1::Envelope::kLoadsFieldNumber,
                   {numbers_of(loads.force_N), numbers_of(loads.torque_N_m), numbers_of(loads.flow)});
}

Bytes Encoder::encode(const Header& header, const AppliedLoads& applied) {
  return serialise(header.at(applied.hydrodynamic.step), v1::Envelope::kAppliedLoadsFieldNumber,
                   {numbers_of(applied.hydrodynamic.force_N), numbers_of(applied.hydrodynamic.torque_N_m),
                    numbers_of(applied.actuation)});
}

Bytes Encoder::encode(const Header& header, const Observation& observation) {
  const Kinematics& kinematics = observation.kinematics;
  return serialise(header.at(kinematics.step), v1::Envelope::kObservationFieldNumber,
                   {numbers_of(kinematics.position_m), numbers_of(kinematics.orientation_wxyz),
                    numbers_of(kinematics.velocity_m_per_s), numbers_of(kinematics.angular_velocity_rad_per_s),
                    numbers_of(observation.loads.force_N), numbers_of(observation.loads.torque_N_m),
                    numbers_of(observation.loads.flow)});
}

Bytes Encoder::encode(const Header& header, const std::vector<double>& action) {
  return serialise(header, v1::Envelope::kActionFieldNumber, {std::span(action)});
}

Bytes Encoder::encode(const Header& header, MessageKind kind) {
  if (body(kind).GetDescriptor()->field_count() > 0)
    throw std::logic_error(std::string(name_of(kind)) + " is not a message without fields: encode it with them");
  return serialise(header);
}

/// The message, but for the arrays of an exchange, lives in an arena whose first block grows to what the
/// largest message so far needed, so that a stream of messages of one size allocates nothing.
struct Decoder::Buffers {
  std::vector<char> block = std::vector<char>(std::size_t{16} << 10);
  std::unique_ptr<google::protobuf::Arena> arena;
  v1::Envelope* envelope = nullptr;
  std::array<Bytes, kMostArrays> arrays{};  ///< in the envelope, or in the bytes that were parsed
  Header header;
  MessageKind kind = MessageKind::none;

  void renew() {
    const std::size_t used = arena ? arena->SpaceAllocated() : 0;
    if (!arena || used > block.size()) {
      arena.reset();
      if (used > block.size()) block = std::vector<char>(2 * used);
      arena = std::make_unique<google::protobuf::Arena>(block.data(), block.size());
    } else {
      arena->Reset();
    }
    envelope = google::protobuf::Arena::CreateMessage<v1::Envelope>(arena.get());
  }
};

Decoder::Decoder() : buffers_(std::make_unique<Buffers>()) {
  // Strangers decide what arrives, so they must not decide what we print; we throw instead.
  static const auto previous_handler = google::protobuf::SetLogHandler(nullptr);
  static_cast<void>(previous_handler);
}
Decoder::~Decoder() = default;

const v1::Envelope& Decoder::envelope() const { return *buffers_->envelope; }

MessageKind Decoder::parse(std::span<const std::byte> bytes) {
  buffers_->kind = MessageKind::none;
  require_at_most(bytes.size(), kLimits.message_bytes, "the message");
  if (!is_intact(bytes)) throw DamagedMessage(bytes.size());
  buffers_->renew();
  v1::Envelope& envelope = *buffers_->envelope;
  const Bytes content = bytes.first(bytes.size() - kChecksumBytes);
  const auto found = find_arrays(content);
  const Bytes rest = found ? content.first(found->begin) : content;
  if (!envelope.ParseFromArray(rest.data(), static_cast<int>(rest.size())))
    throw MalformedMessage(std::to_string(bytes.size()) + " bytes are not an Envelope");
  buffers_->arrays = found ? found->arrays : arrays_of(envelope);
  const auto kind = static_cast<MessageKind>(found ? found->message : envelope.body_case());
  if (kind == MessageKind::none) throw MalformedMessage("the Envelope is empty or holds an unknown message");
  buffers_->header = {envelope.protocol_major(), envelope.protocol_minor(), envelope.session_id(), envelope.epoch(),
                      envelope.sequence(),       envelope.attempt(),        envelope.step()};
  // A Hello of another version must be readable, so that it can be refused with a reason.
  if (envelope.protocol_major() != session::kProtocolMajor && kind != MessageKind::hello &&
      kind != MessageKind::refusal)
    throw MalformedMessage("it is of protocol version " + std::to_string(envelope.protocol_major()) + ", not " +
                           std::to_string(session::kProtocolMajor));
  return buffers_->kind = kind;
}

MessageKind Decoder::kind() const { return buffers_->kind; }
const Header& Decoder::header() const { return buffers_->header; }

void Decoder::read(session::Configured& configured) const {
  const Doubles& nodes = buffers_->envelope->configured().driving_nodes();
  require_at_most(nodes.size(), kLimits.driving_nodes, "driving_nodes");
  require_finite(nodes.data(), nodes.size(), "driving_nodes");
  configured.driving_nodes.assign(nodes.begin(), nodes.end());
}

void Decoder::read(Kinematics& kinematics, Eigen::Index bodies) const {
  const std::array<Bytes, kMostArrays>& arrays = buffers_->arrays;
  kinematics.step = header().step;
  read_array(arrays[0], bodies, "position_m", kinematics.position_m);
  read_array(arrays[1], bodies, "orientation_wxyz", kinematics.orientation_wxyz);
  read_array(arrays[2], bodies, "velocity_m_per_s", kinematics.velocity_m_per_s);
  read_array(arrays[3], bodies, "angular_velocity_rad_per_s", kinematics.angular_velocity_rad_per_s);
}

void Decoder::read(Loads& loads, Eigen::Index bodies, Eigen::Index flow) const {
  read(loads, bodies);
  loads.flow.resize(flow);
  read_numbers(buffers_->arrays[2], "flow", loads.flow);
}

void Decoder::read(Loads& loads, Eigen::Index bodies) const {
  loads.step = header().step;
  read_array(buffers_->arrays[0], bodies, "force_N", loads.force_N);
  read_array(buffers_->arrays[1], bodies, "torque_N_m", loads.torque_N_m);
}

void Decoder::read(Observation& observation, Eigen::Index bodies, Eigen::Index flow) const {
  read(observation.kinematics, bodies);
  observation.loads.step = header().step - 1;
  read_array(buffers_->arrays[4], bodies, "force_N", observation.loads.force_N);
  read_array(buffers_->arrays[5], bodies, "torque_N_m", observation.loads.torque_N_m);
  observation.loads.flow.resize(flow);
  read_numbers(buffers_->arrays[6], "flow", observation.loads.flow);
}

void Decoder::read(std::vector<double>& action) const { read_numbers(buffers_->arrays[0], "value", action); }

void Decoder::read(AppliedLoads& applied, Eigen::Index bodies, Eigen::Index actuators,
                   Eigen::Index driving_nodes) const {
  read(applied.hydrodynamic, bodies);
  applied.actuation.resize(actuators, driving_nodes);
  read_numbers(buffers_->arrays[2], "actuation", applied.actuation);
}

}  // namespace copepod::conversion
