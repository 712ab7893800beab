#include "ranks/failure_packet.hpp"

#include <algorithm>
#include <vector>

#include "ranks/packing.hpp"

namespace copepod::fluid {

namespace {

template <class Archive, class Report>
void describe(Archive& archive, Report& report) {
  archive(report.code);
  archive(report.rank);
  archive(report.step);
  archive(report.component);
  archive(report.host);
  archive(report.reason);
}

/// At most `length` bytes of `text`, without cutting a UTF-8 character in two.
std::string shortened(const std::string& text, std::size_t length) {
  if (text.size() <= length) return text;
  while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U) --length;
  return text.substr(0, length);
}

}  // namespace

FailurePacket pack_failure(FailureReport report) {
  report.component = shortened(report.component, 64);
  report.host = shortened(report.host, 256);
  report.reason = shortened(report.reason, 1600);
  std::vector<std::byte> bytes;
  Packer packer(bytes);
  describe(packer, report);
  FailurePacket packet{};
  std::copy(bytes.begin(), bytes.end(), packet.begin());
  return packet;
}

FailureReport unpack_failure(const FailurePacket& packet) {
  FailureReport report;
  Unpacker unpacker(packet);
  describe(unpacker, report);
  return report;
}

}  // namespace copepod::fluid
