#pragma once

#include <exception>
#include <string>

#include "contract/errors.hpp"
#include "copepod.h"
#include "run/program.hpp"

namespace copepod {

/// The caller's mistake.
class Misuse : public Error {
 public:
  explicit Misuse(const std::string& reason) : Error(static_cast<ExitCode>(COPEPOD_MISUSE), reason) {}
};

inline void require(bool makes_sense, const std::string& reason) {
  if (!makes_sense) throw Misuse(reason);
}

void require_arguments(const auto*... arguments) {
  require(((arguments != nullptr) && ...), "an argument is NULL (a place is needed there). See the header.");
}

/// What copepod_error returns.
inline thread_local std::string message_of_last_failure;

/// Runs an action of the C interface and turns whatever it throws into a code and a message.
template <class Action>
int guarded(const Action& action) noexcept {
  try {
    action();
    return static_cast<int>(ExitCode::finished);
  } catch (const std::exception& error) {
    const FailureReport report = coupler::report_of(error, -1);
    message_of_last_failure = (report.step < 0 ? "" : "at step " + std::to_string(report.step) + ": ") + report.reason;
    return static_cast<int>(report.code);
  }
}

}  // namespace copepod
