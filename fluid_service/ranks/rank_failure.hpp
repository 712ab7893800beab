#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <new>
#include <string>

#include "contract/errors.hpp"
#include "conversion/limits.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

/// The report of an exception of rank `rank`; `step` is used where the error has none.
inline FailureReport failure_of_rank(const std::exception& error, int rank, std::int64_t step) {
  FailureReport report{ExitCode::solver_failed, "fluid", host_name(), rank, step, error.what()};
  if (const auto* known = dynamic_cast<const Error*>(&error)) {
    report.code = known->code();
    if (known->step() >= 0) report.step = known->step();
  } else if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    report.reason = "out of memory (the rank's block of cells does not fit). Use more machines or a smaller domain.";
  }
  return report;
}

/// A failure report as one message of fixed size, small enough to be sent without a handshake.
struct FailurePacket {
  ExitCode code = ExitCode::solver_failed;
  int rank = 0;
  std::int64_t step = -1;
  std::array<char, 65> component{};  ///< each text ends with a zero
  std::array<char, 257> host{};
  std::array<char, 1601> reason{};
};

/// @param report  its texts are cut to what fits, but no UTF-8 character in two
inline FailurePacket pack_failure(const FailureReport& report) {
  FailurePacket packet{report.code, report.rank, report.step};
  const auto copy = [](const std::string& text, auto& target) {
    std::ranges::copy(conversion::as_utf8(text, target.size() - 1), target.begin());
  };
  copy(report.component, packet.component);
  copy(report.host, packet.host);
  copy(report.reason, packet.reason);
  return packet;
}

inline FailureReport unpack_failure(const FailurePacket& packet) {
  return {packet.code, packet.component.data(), packet.host.data(), packet.rank, packet.step, packet.reason.data()};
}

}  // namespace copepod::fluid
