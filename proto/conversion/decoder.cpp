#include "conversion/decoder.hpp"

#include <array>
#include <vector>

#include <google/protobuf/arena.h>
#include <google/protobuf/stubs/logging.h>

#include "conversion/arrays.hpp"
#include "conversion/checksum.hpp"
#include "conversion/enumerations.hpp"
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

const std::string& read_text(const std::string& text, const char* name) {
  require_at_most(text.size(), kLimits.string_bytes, name);
  return text;
}

Capabilities read_capabilities(const v1::Capabilities& wire) {
  require_at_most(static_cast<std::size_t>(wire.features_size()), kLimits.features, "features");
  Capabilities capabilities;
  capabilities.name = read_text(wire.name(), "capabilities.name");
  capabilities.version = read_text(wire.version(), "capabilities.version");
  for (const std::string& feature : wire.features()) capabilities.features.insert(read_text(feature, "feature"));
  return capabilities;
}

/// Codes of other builds must not turn into nonsense, nor a failure into success.
ExitCode read_exit_code(int code) {
  switch (static_cast<ExitCode>(code)) {
    case ExitCode::bad_case:
    case ExitCode::refused:
    case ExitCode::component_lost:
    case ExitCode::solver_failed:
    case ExitCode::storage_failed:
    case ExitCode::deadline_passed:
    case ExitCode::interrupted:
    case ExitCode::terminated:
      return static_cast<ExitCode>(code);
    case ExitCode::finished:
      break;
  }
  return ExitCode::solver_failed;
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

void Decoder::read(session::Hello& hello) const {
  const v1::Hello& wire = buffers_->envelope->hello();
  hello.role = from_wire<session::Role>(wire.role(), *v1::Role_descriptor(), "role");
  hello.lane = from_wire<session::Lane>(wire.lane(), *v1::Lane_descriptor(), "lane");
  hello.versions = {wire.versions().major(), wire.versions().minor_min(), wire.versions().minor_max()};
  hello.session_token = read_text(wire.session_token(), "session_token");
  hello.capabilities = read_capabilities(wire.capabilities());
  hello.host = read_text(wire.host(), "host");
  hello.pid = wire.pid();
  hello.ranks = wire.ranks();
  hello.instance = wire.instance();
}

void Decoder::read(session::Welcome& welcome) const {
  const v1::Welcome& wire = buffers_->envelope->welcome();
  welcome = {wire.minor(), wire.session_id(), wire.epoch()};
}

void Decoder::read(session::Refusal& refusal) const {
  refusal.reason = read_text(buffers_->envelope->refusal().reason(), "reason");
}

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

void Decoder::read(session::CheckpointPath& path) const {
  const bool saves = kind() == MessageKind::save;
  path.path = read_text(saves ? buffers_->envelope->save().path() : buffers_->envelope->restore().path(), "path");
}

namespace {

void read_phases(const google::protobuf::RepeatedPtrField<std::string>& wire, std::set<std::string>& phases) {
  require_at_most(static_cast<std::size_t>(wire.size()), kLimits.timers, "phases");
  phases.clear();
  for (const std::string& phase : wire) phases.insert(read_text(phase, "phase"));
}

}  // namespace

void Decoder::read(SolverSummary& summary) const {
  const v1::Summary& wire = buffers_->envelope->summary();
  require_at_most(wire.seconds().size(), kLimits.timers, "seconds");
  summary.digest = wire.digest();
  summary.cell_updates = wire.cell_updates();
  summary.ranks = static_cast<int>(wire.ranks());
  summary.seconds.clear();
  for (const auto& [phase, seconds] : wire.seconds())
    summary.seconds[read_text(phase, "phase")] = read_finite(seconds, "seconds");
  read_phases(wire.body_phases(), summary.body_phases);
  read_phases(wire.waiting_phases(), summary.waiting_phases);
  summary.mass_drift.reset();
  if (wire.has_mass_drift()) summary.mass_drift = read_finite(wire.mass_drift(), "mass_drift");
  summary.momentum_drift.reset();
  if (wire.has_momentum_drift()) summary.momentum_drift = read_finite(wire.momentum_drift(), "momentum_drift");
}

void Decoder::read(session::Ping& ping) const { ping.stamp_ns = buffers_->envelope->ping().stamp_ns(); }

void Decoder::read(session::Pong& pong) const {
  const v1::Pong& wire = buffers_->envelope->pong();
  pong.stamp_ns = wire.stamp_ns();
  pong.step = wire.step();
  pong.phase = from_wire<session::Phase>(wire.phase(), *v1::Phase_descriptor(), "phase");
  pong.progress = wire.progress();
  pong.received_sequence = wire.received_sequence();
  pong.replied_sequence = wire.replied_sequence();
  pong.awaited_rank = wire.awaited_rank();
}

void Decoder::read(session::Saved& saved) const {
  saved.problem = read_text(buffers_->envelope->saved().problem(), "problem");
}

void Decoder::read(FailureReport& failure) const {
  const bool aborts = kind() == MessageKind::abort;
  const v1::Failure& wire = aborts ? buffers_->envelope->abort().failure() : buffers_->envelope->failure();
  failure.code = read_exit_code(wire.code());
  failure.component = read_text(wire.component(), "component");
  failure.host = read_text(wire.host(), "host");
  failure.rank = wire.rank();
  failure.step = wire.step();
  failure.reason = read_text(wire.reason(), "reason");
}

}  // namespace copepod::conversion
