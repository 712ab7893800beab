#include "conversion/encoder.hpp"

#include <stdexcept>
#include <vector>

#include "conversion/arrays.hpp"
#include "conversion/checksum.hpp"
#include "conversion/limits.hpp"
#include "conversion/packed_arrays.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

using session::Header;
using session::MessageKind;

namespace {

template <class Matrix>
std::span<const double> numbers_of(const Matrix& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
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
  assign(*buffers_->envelope.mutable_configured()->mutable_driving_nodes(), configured.driving_nodes.data(),
         static_cast<Eigen::Index>(configured.driving_nodes.size()));
  return serialise(header);
}

Bytes Encoder::encode(const Header& header, const Kinematics& kinematics) {
  return serialise(header.at(kinematics.step), v1::Envelope::kKinematicsFieldNumber,
                   {numbers_of(kinematics.position_m), numbers_of(kinematics.orientation_wxyz),
                    numbers_of(kinematics.velocity_m_per_s), numbers_of(kinematics.angular_velocity_rad_per_s)});
}

Bytes Encoder::encode(const Header& header, const Loads& loads) {
  return serialise(header.at(loads.step), v1::Envelope::kLoadsFieldNumber,
                   {numbers_of(loads.force_N), numbers_of(loads.torque_N_m)});
}

Bytes Encoder::encode(const Header& header, const AppliedLoads& applied) {
  return serialise(header.at(applied.hydrodynamic.step), v1::Envelope::kAppliedLoadsFieldNumber,
                   {numbers_of(applied.hydrodynamic.force_N), numbers_of(applied.hydrodynamic.torque_N_m),
                    numbers_of(applied.actuation)});
}

Bytes Encoder::encode(const Header& header, MessageKind kind) {
  if (body(kind).GetDescriptor()->field_count() > 0)
    throw std::logic_error(std::string(name_of(kind)) + " is not a message without fields: encode it with them");
  return serialise(header);
}

}  // namespace copepod::conversion
