#include "ranks/rank_failure.hpp"

#include <algorithm>
#include <new>
#include <string>

#include "conversion/text.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

namespace {

/// Without cutting a UTF-8 character in two.
template <std::size_t size>
std::array<char, size> shortened(const std::string& text) {
  std::array<char, size> result{};
  std::ranges::copy(conversion::as_utf8(text, size - 1), result.begin());
  return result;
}

}  // namespace

FailureReport failure_of_rank(const std::exception& error, int rank, std::int64_t step) {
  FailureReport report{ExitCode::solver_failed, "fluid", host_name(), rank, step, error.what()};
  if (const auto* known = dynamic_cast<const Error*>(&error)) {
    report.code = known->code();
    if (known->step() >= 0) report.step = known->step();
  } else if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    report.reason = "out of memory (the rank's block of cells does not fit). Use more machines or a smaller domain.";
  }
  return report;
}

FailurePacket pack_failure(const FailureReport& report) {
  return {report.code,
          report.rank,
          report.step,
          shortened<65>(report.component),
          shortened<257>(report.host),
          shortened<1601>(report.reason)};
}

FailureReport unpack_failure(const FailurePacket& packet) {
  return {packet.code, packet.component.data(), packet.host.data(), packet.rank, packet.step, packet.reason.data()};
}

}  // namespace copepod::fluid
