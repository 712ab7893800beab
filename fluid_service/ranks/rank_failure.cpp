#include "ranks/rank_failure.hpp"

#include <algorithm>
#include <new>
#include <string>
#include <vector>

#include "ranks/packing.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

namespace {

template <class Archive, class Report>
void visit_report(Archive& archive, Report& report) {
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

FailureReport failure_of_rank(const std::exception& error, int rank, std::int64_t step) {
  FailureReport report;
  report.component = "fluid";
  report.host = host_name();
  report.rank = rank;
  report.step = step;
  report.reason = error.what();
  if (const auto* known = dynamic_cast<const Error*>(&error)) {
    report.code = known->code();
    if (known->step() >= 0) report.step = known->step();
  } else if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    report.reason = "out of memory (the rank's block of cells does not fit). Use more machines or a smaller domain.";
  }
  return report;
}

FailurePacket pack_failure(FailureReport report) {
  report.component = shortened(report.component, 64);
  report.host = shortened(report.host, 256);
  report.reason = shortened(report.reason, 1600);
  std::vector<std::byte> bytes;
  Packer packer(bytes);
  visit_report(packer, report);
  FailurePacket packet{};
  std::copy(bytes.begin(), bytes.end(), packet.begin());
  return packet;
}

FailureReport unpack_failure(const FailurePacket& packet) {
  FailureReport report;
  Unpacker unpacker(packet);
  visit_report(unpacker, report);
  return report;
}

}  // namespace copepod::fluid
