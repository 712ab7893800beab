#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace copepod {

/// Exit codes of every Copepod process and of `deploy/copepod`.
enum class ExitCode : int {
  finished = 0,
  bad_case = 2,          ///< bad case file or command line
  refused = 65,          ///< refused by the peer: version, role, key, capability
  component_lost = 69,   ///< a component died, froze or hung
  solver_failed = 70,    ///< diverged, NaN
  storage_failed = 73,   ///< output or checkpoint could not be written or read
  deadline_passed = 74,  ///< no answer came in time
  interrupted = 130,     ///< SIGINT
  terminated = 143,      ///< SIGTERM
};

/// Where and why a run ended early; travels between processes as a Failure message.
/// Messages follow "problem (why). What to do.".
struct FailureReport {
  ExitCode code = ExitCode::solver_failed;  ///< of the process
  std::string component;                    ///< "coupler", "fluid", "body" or a component's own name
  std::string host;                         ///< where it ran
  int rank = 0;                             ///< that failed
  std::int64_t step = -1;                   ///< coupling step, −1 before the first
  std::string reason;                       ///< one sentence that names problem, cause and remedy
};

/// Base of all errors that end a run. `what()` is the reason; rank and step are filled in where they are known.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& reason, int rank = 0, std::int64_t step = -1)
      : std::runtime_error(reason), code_(code), rank_(rank), step_(step) {}
  [[nodiscard]] ExitCode code() const { return code_; }      ///< of the process
  [[nodiscard]] int rank() const { return rank_; }           ///< that failed
  [[nodiscard]] std::int64_t step() const { return step_; }  ///< coupling step, −1 if not known

 private:
  ExitCode code_;
  int rank_;
  std::int64_t step_;
};

/// The case asks for something impossible or contradictory.
class CaseError : public Error {
 public:
  explicit CaseError(const std::string& reason) : Error(ExitCode::bad_case, reason) {}
};

/// A solver cannot continue: diverged, NaN, coinciding bodies.
class SolverError : public Error {
 public:
  explicit SolverError(const std::string& reason, int rank = 0, std::int64_t step = -1)
      : Error(ExitCode::solver_failed, reason, rank, step) {}
};

/// Output or a checkpoint could not be written or read.
class StorageError : public Error {
 public:
  explicit StorageError(const std::string& reason) : Error(ExitCode::storage_failed, reason) {}
};

/// The peer refused us, or we it: version, role, key, capability.
class Refused : public Error {
 public:
  explicit Refused(const std::string& reason) : Error(ExitCode::refused, reason) {}
};

/// A component died, froze or hung.
class ComponentLost : public Error {
 public:
  explicit ComponentLost(const std::string& reason, std::int64_t step = -1)
      : Error(ExitCode::component_lost, reason, 0, step) {}

  /// Another component was lost: which one, on which host and rank.
  explicit ComponentLost(FailureReport lost)
      : Error(ExitCode::component_lost, lost.reason, lost.rank, lost.step), lost_(std::move(lost)) {}

  /// Absent if it is the thrower itself that cannot continue.
  [[nodiscard]] const std::optional<FailureReport>& lost() const { return lost_; }

 private:
  std::optional<FailureReport> lost_;
};

/// No answer came before the deadline.
class DeadlinePassed : public Error {
 public:
  explicit DeadlinePassed(const std::string& reason, std::int64_t step = -1)
      : Error(ExitCode::deadline_passed, reason, 0, step) {}
};

/// A signal asked us to stop; `signal` is SIGINT or SIGTERM.
class Interrupted : public Error {
 public:
  explicit Interrupted(int signal, std::int64_t step = -1,
                       const std::string& remedy = "Run again, with --resume if there is a checkpoint.")
      : Error(static_cast<ExitCode>(128 + signal),
              "stopped by signal " + std::to_string(signal) + " (sent by a user or another program). " + remedy, 0,
              step) {}
};

/// A failure that a peer reported in a Failure message; keeps the peer's report unchanged.
class PeerFailed : public Error {
 public:
  explicit PeerFailed(FailureReport report)
      : Error(report.code, report.reason, report.rank, report.step), report_(std::move(report)) {}
  [[nodiscard]] const FailureReport& report() const { return report_; }  ///< of the peer

 private:
  FailureReport report_;
};

}  // namespace copepod
