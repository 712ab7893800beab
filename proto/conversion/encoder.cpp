#include "conversion/encoder.hpp"

#include <stdexcept>
#include <vector>

#include "conversion/arrays.hpp"
#include "conversion/checksum.hpp"
#include "conversion/enumerations.hpp"
#include "conversion/limits.hpp"
#include "conversion/packed_arrays.hpp"
#include "conversion/text.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

using session::Header;
using session::MessageKind;

namespace {

Header at_step(Header header, std::int64_t step) {
  header.step = step;
  return header;
}

template <class Matrix>
std::span<const double> numbers_of(const Matrix& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}

void write_capabilities(const Capabilities& capabilities, v1::Capabilities& wire) {
  wire.set_name(capabilities.name);
  wire.set_version(capabilities.version);
  wire.clear_features();
  for (const std::string& feature : capabilities.features) wire.add_features(feature);
}

void write_failure(const FailureReport& failure, v1::Failure& wire) {
  wire.set_code(static_cast<int>(failure.code));
  wire.set_component(as_utf8(failure.component, kLimits.string_bytes));
  wire.set_host(as_utf8(failure.host, kLimits.string_bytes));
  wire.set_rank(failure.rank);
  wire.set_step(failure.step);
  wire.set_reason(as_utf8(failure.reason, kLimits.string_bytes));
}

}  // namespace

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

v1::Envelope& Encoder::envelope() { return buffers_->envelope; }

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

Bytes Encoder::encode(const Header& header, const session::Hello& hello) {
  v1::Hello& wire = *buffers_->envelope.mutable_hello();
  wire.set_role(to_wire<v1::Role>(hello.role));
  wire.set_lane(to_wire<v1::Lane>(hello.lane));
  wire.mutable_versions()->set_major(hello.versions.major);
  wire.mutable_versions()->set_minor_min(hello.versions.minor_min);
  wire.mutable_versions()->set_minor_max(hello.versions.minor_max);
  wire.set_session_token(hello.session_token);
  write_capabilities(hello.capabilities, *wire.mutable_capabilities());
  wire.set_host(hello.host);
  wire.set_pid(hello.pid);
  wire.set_ranks(hello.ranks);
  wire.set_instance(hello.instance);
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const session::Welcome& welcome) {
  v1::Welcome& wire = *buffers_->envelope.mutable_welcome();
  wire.set_minor(welcome.minor);
  wire.set_session_id(welcome.session_id);
  wire.set_epoch(welcome.epoch);
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const session::Refusal& refusal) {
  buffers_->envelope.mutable_refusal()->set_reason(as_utf8(refusal.reason, kLimits.string_bytes));
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const session::Configured& configured) {
  assign(*buffers_->envelope.mutable_configured()->mutable_driving_nodes(), configured.driving_nodes.data(),
         static_cast<Eigen::Index>(configured.driving_nodes.size()));
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const Kinematics& kinematics) {
  return serialise(at_step(header, kinematics.step), v1::Envelope::kKinematicsFieldNumber,
                   {numbers_of(kinematics.position_m), numbers_of(kinematics.orientation_wxyz),
                    numbers_of(kinematics.velocity_m_per_s), numbers_of(kinematics.angular_velocity_rad_per_s)});
}

Bytes Encoder::encode(const Header& header, const Loads& loads) {
  return serialise(at_step(header, loads.step), v1::Envelope::kLoadsFieldNumber,
                   {numbers_of(loads.force_N), numbers_of(loads.torque_N_m)});
}

Bytes Encoder::encode(const Header& header, const AppliedLoads& applied) {
  return serialise(at_step(header, applied.hydrodynamic.step), v1::Envelope::kAppliedLoadsFieldNumber,
                   {numbers_of(applied.hydrodynamic.force_N), numbers_of(applied.hydrodynamic.torque_N_m),
                    numbers_of(applied.actuation)});
}

Bytes Encoder::encode(const Header& header, const SolverSummary& summary) {
  v1::Summary& wire = *buffers_->envelope.mutable_summary();
  wire.Clear();
  wire.set_digest(summary.digest);
  wire.set_cell_updates(summary.cell_updates);
  wire.set_ranks(static_cast<std::uint32_t>(summary.ranks));
  for (const auto& [phase, seconds] : summary.seconds) (*wire.mutable_seconds())[phase] = seconds;
  for (const std::string& phase : summary.body_phases) wire.add_body_phases(phase);
  for (const std::string& phase : summary.waiting_phases) wire.add_waiting_phases(phase);
  if (summary.mass_drift) wire.set_mass_drift(*summary.mass_drift);
  if (summary.momentum_drift) wire.set_momentum_drift(*summary.momentum_drift);
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const session::Ping& ping) {
  buffers_->envelope.mutable_ping()->set_stamp_ns(ping.stamp_ns);
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const session::Pong& pong) {
  v1::Pong& wire = *buffers_->envelope.mutable_pong();
  wire.set_stamp_ns(pong.stamp_ns);
  wire.set_step(pong.step);
  wire.set_phase(to_wire<v1::Phase>(pong.phase));
  wire.set_progress(pong.progress);
  wire.set_received_sequence(pong.received_sequence);
  wire.set_replied_sequence(pong.replied_sequence);
  wire.set_awaited_rank(pong.awaited_rank);
  return serialise(at_step(header, pong.step));
}

Bytes Encoder::encode(const Header& header, const FailureReport& failure) {
  write_failure(failure, *buffers_->envelope.mutable_failure());
  return serialise(at_step(header, failure.step));
}

Bytes Encoder::encode_abort(const Header& header, const FailureReport& failure) {
  write_failure(failure, *buffers_->envelope.mutable_abort()->mutable_failure());
  return serialise(at_step(header, failure.step));
}

Bytes Encoder::encode(const Header& header, MessageKind kind, const session::CheckpointPath& path) {
  require_at_most(path.path.size(), kLimits.string_bytes, "the path");
  if (kind == MessageKind::save) buffers_->envelope.mutable_save()->set_path(path.path);
  if (kind == MessageKind::restore) buffers_->envelope.mutable_restore()->set_path(path.path);
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const session::Saved& saved) {
  buffers_->envelope.mutable_saved()->set_problem(as_utf8(saved.problem, kLimits.string_bytes));
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, MessageKind kind) {
  v1::Envelope& envelope = buffers_->envelope;
  const auto* field = envelope.GetDescriptor()->FindFieldByNumber(static_cast<int>(kind));
  if (field == nullptr || field->message_type()->field_count() > 0)
    throw std::logic_error(std::string(name_of(kind)) + " is not a message without fields: encode it with them");
  envelope.GetReflection()->MutableMessage(&envelope, field);
  return serialise(header);
}

}  // namespace copepod::conversion
