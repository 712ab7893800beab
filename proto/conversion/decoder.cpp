#include "conversion/decoder.hpp"

#include <array>
#include <vector>

#include <google/protobuf/arena.h>
#include <google/protobuf/stubs/logging.h>

#include "conversion/arrays.hpp"
#include "conversion/checksum.hpp"
#include "conversion/limits.hpp"
#include "conversion/packed_arrays.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

using session::Header;
using session::MessageKind;

namespace {

Bytes bytes_of(const Doubles& field) {
  return std::as_bytes(std::span(field.data(), static_cast<std::size_t>(field.size())));
}

/// The arrays of a message that Protobuf's parser has read.
std::array<Bytes, kMostArrays> arrays_of(const v1::Envelope& envelope) {
  const v1::Kinematics& kinematics = envelope.kinematics();
  const v1::Loads& loads = envelope.loads();
  const v1::AppliedLoads& applied = envelope.applied_loads();
  switch (envelope.body_case()) {
    case v1::Envelope::kKinematics:
      return {bytes_of(kinematics.position_m()), bytes_of(kinematics.orientation_wxyz()),
              bytes_of(kinematics.velocity_m_per_s()), bytes_of(kinematics.angular_velocity_rad_per_s())};
    case v1::Envelope::kLoads:
      return {bytes_of(loads.force_n()), bytes_of(loads.torque_n_m())};
    case v1::Envelope::kAppliedLoads:
      return {bytes_of(applied.force_n()), bytes_of(applied.torque_n_m()), bytes_of(applied.actuation())};
    default:
      return {};
  }
}

}  // namespace

/// The message, but for the arrays of an exchange, lives in an arena whose first block grows to what the
/// largest message so far needed, so that a stream of messages of one size allocates nothing.
struct Decoder::Buffers {
  std::vector<char> block = std::vector<char>(std::size_t{16} << 10);
  std::unique_ptr<google::protobuf::Arena> arena;
  v1::Envelope* envelope = nullptr;
  std::array<Bytes, kMostArrays> arrays{};  ///< in the envelope, or in the bytes that were parsed
  Header header;
  MessageKind kind = MessageKind::none;

  void make_arena() {
    google::protobuf::ArenaOptions options;
    options.initial_block = block.data();
    options.initial_block_size = block.size();
    arena = std::make_unique<google::protobuf::Arena>(options);
  }

  void renew() {
    const std::size_t used = arena ? arena->SpaceAllocated() : 0;
    if (!arena || used > block.size()) {
      arena.reset();
      if (used > block.size()) block = std::vector<char>(2 * used);
      make_arena();
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
  if (!envelope.ParseFromArray(rest.data(), static_cast<int>(rest.size()))) {
    throw MalformedMessage(std::to_string(bytes.size()) + " bytes are not an Envelope");
  }
  buffers_->arrays = found ? found->arrays : arrays_of(envelope);
  const auto kind = static_cast<MessageKind>(found ? found->message : envelope.body_case());
  if (kind == MessageKind::none) throw MalformedMessage("the Envelope is empty or holds an unknown message");
  buffers_->header = {envelope.protocol_major(), envelope.protocol_minor(), envelope.session_id(), envelope.epoch(),
                      envelope.sequence(),       envelope.attempt(),        envelope.step()};
  // A Hello of another version must be readable, so that it can be refused with a reason.
  if (envelope.protocol_major() != session::kProtocolMajor && kind != MessageKind::hello &&
      kind != MessageKind::refusal) {
    throw MalformedMessage("it is of protocol version " + std::to_string(envelope.protocol_major()) + ", not " +
                           std::to_string(session::kProtocolMajor));
  }
  return buffers_->kind = kind;
}

MessageKind Decoder::kind() const { return buffers_->kind; }
const Header& Decoder::header() const { return buffers_->header; }

void Decoder::read(session::Configured& configured) const {
  const Doubles& nodes = buffers_->envelope->configured().driving_nodes();
  require_at_most(static_cast<std::size_t>(nodes.size()), kLimits.driving_nodes, "driving_nodes");
  require_finite(nodes.data(), nodes.size(), "driving_nodes");
  configured.driving_nodes.assign(nodes.begin(), nodes.end());
}

void Decoder::read(Kinematics& kinematics, Eigen::Index bodies) const {
  const auto& [position, orientation, velocity, angular_velocity] = buffers_->arrays;
  kinematics.step = header().step;
  read_array(position, bodies, "position_m", kinematics.position_m);
  read_array(orientation, bodies, "orientation_wxyz", kinematics.orientation_wxyz);
  read_array(velocity, bodies, "velocity_m_per_s", kinematics.velocity_m_per_s);
  read_array(angular_velocity, bodies, "angular_velocity_rad_per_s", kinematics.angular_velocity_rad_per_s);
}

void Decoder::read(Loads& loads, Eigen::Index bodies) const {
  loads.step = header().step;
  read_array(buffers_->arrays[0], bodies, "force_N", loads.force_N);
  read_array(buffers_->arrays[1], bodies, "torque_N_m", loads.torque_N_m);
}

void Decoder::read(AppliedLoads& applied, Eigen::Index bodies, Eigen::Index actuators,
                   Eigen::Index driving_nodes) const {
  read(applied.hydrodynamic, bodies);
  const Bytes& values = buffers_->arrays[2];
  require_length(values.size() / sizeof(double), actuators * driving_nodes, "actuation");
  applied.actuation.resize(actuators, driving_nodes);
  if (!vector_passes().copy_finite(values.data(), static_cast<std::size_t>(applied.actuation.size()),
                                   applied.actuation.data()))
    throw NotFinite("actuation holds a number that is not finite");
}

}  // namespace copepod::conversion
