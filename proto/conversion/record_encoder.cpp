#include "conversion/record_encoder.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include "conversion/enumerations.hpp"
#include "copepod/v1/envelope.pb.h"
#include "copepod/v1/recording.pb.h"

namespace copepod::conversion {

namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

constexpr std::size_t kLargestHead = 128;  ///< all fields but the envelope, with room to spare

std::uint32_t field_tag(int field) { return WireFormatLite::MakeTag(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED); }

std::size_t size_of(std::uint32_t number) { return CodedOutputStream::VarintSize32(number); }

void add_with_imports(const google::protobuf::FileDescriptor& file, google::protobuf::FileDescriptorSet& schema) {
  for (const auto& known : schema.file()) {
    if (known.name() == file.name()) return;
  }
  for (int i = 0; i < file.dependency_count(); ++i) add_with_imports(*file.dependency(i), schema);
  file.CopyTo(schema.add_file());
}

}  // namespace

struct RecordEncoder::Buffers {
  v1::Record record;
  v1::RecordedMessage label;
  std::vector<std::byte> bytes = std::vector<std::byte>(kLargestHead);

  [[nodiscard]] std::uint8_t* start() { return reinterpret_cast<std::uint8_t*>(bytes.data()); }
};

RecordEncoder::RecordEncoder() : buffers_(std::make_unique<Buffers>()) {}
RecordEncoder::~RecordEncoder() = default;

RecordEncoder::Bytes RecordEncoder::serialise() {
  const std::size_t size = buffers_->record.ByteSizeLong();
  if (buffers_->bytes.size() < size) buffers_->bytes.resize(size);
  buffers_->record.SerializeWithCachedSizesToArray(buffers_->start());
  return {buffers_->bytes.data(), size};
}

RecordEncoder::Bytes RecordEncoder::encode(const RecordingHeader& header) {
  v1::RecordingHeader& wire = *buffers_->record.mutable_header();
  wire.set_process(header.process);
  wire.set_rank(header.rank);
  wire.set_host(header.host);
  wire.set_clock(header.clock);
  wire.set_monotonic_ns(header.monotonic_ns);
  wire.set_utc_ns(header.utc_ns);
  return serialise();
}

RecordEncoder::Bytes RecordEncoder::encode_phase(std::string_view name, std::int64_t step, std::uint64_t begin_ns,
                                                 std::uint64_t duration_ns) {
  v1::RecordedPhase& wire = *buffers_->record.mutable_phase();
  wire.mutable_name()->assign(name);
  wire.set_step(step);
  wire.set_begin_ns(begin_ns);
  wire.set_duration_ns(duration_ns);
  return serialise();
}

/// A message on the wire is its fields one after the other, so the last one may follow later.
RecordEncoder::Bytes RecordEncoder::encode_head(const MessageLabel& label, std::size_t size) {
  v1::RecordedMessage& wire = buffers_->label;
  wire.set_time_ns(label.time_ns);
  wire.set_direction(to_wire<v1::Direction>(label.direction));
  wire.set_role(label.role ? to_wire<v1::Role>(*label.role) : v1::ROLE_UNSPECIFIED);
  wire.set_lane(label.lane ? to_wire<v1::Lane>(*label.lane) : v1::LANE_UNSPECIFIED);
  const std::uint32_t envelope_tag = field_tag(v1::RecordedMessage::kEnvelopeFieldNumber);
  const auto envelope_size = static_cast<std::uint32_t>(size);
  const auto label_size = static_cast<std::uint32_t>(wire.ByteSizeLong());
  const auto message_size =
      static_cast<std::uint32_t>(label_size + size_of(envelope_tag) + size_of(envelope_size) + envelope_size);
  std::uint8_t* end = buffers_->start();
  end = CodedOutputStream::WriteTagToArray(field_tag(v1::Record::kMessageFieldNumber), end);
  end = CodedOutputStream::WriteVarint32ToArray(message_size, end);
  end = wire.SerializeWithCachedSizesToArray(end);
  end = CodedOutputStream::WriteTagToArray(envelope_tag, end);
  end = CodedOutputStream::WriteVarint32ToArray(envelope_size, end);
  return {buffers_->bytes.data(), static_cast<std::size_t>(end - buffers_->start())};
}

std::vector<std::byte> recording_schema() {
  google::protobuf::FileDescriptorSet schema;
  add_with_imports(*v1::Envelope::descriptor()->file(), schema);
  add_with_imports(*v1::Record::descriptor()->file(), schema);
  std::vector<std::byte> bytes(schema.ByteSizeLong());
  schema.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace copepod::conversion
