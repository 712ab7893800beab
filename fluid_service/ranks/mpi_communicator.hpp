#pragma once

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>

#include <mpi.h>

#include "ranks/communicator.hpp"
#include "ranks/heartbeats.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

/// Pauses between two polls of a wait: yields at first, then sleeps ever longer.
///
/// docs/decisions/waiting_ranks_sleep.md has the measurement behind the figures.
class Backoff {
 public:
  static constexpr double spin_s = 100e-6;
  static constexpr double longest_pause_s = 1e-3;

  /// Sleep after a wait, 0 to yield: a message that comes within `spin_s` is seen at once; later the sleep adds
  /// at most an eighth to the wait.
  static constexpr double pause_s(double waited_s) {
    return waited_s < spin_s ? 0.0 : std::min(waited_s / 8, longest_pause_s);
  }

  void pause() const {
    const double sleep_s = pause_s(waited_s());
    if (sleep_s > 0.0)
      std::this_thread::sleep_for(std::chrono::duration<double>(sleep_s));
    else
      std::this_thread::yield();
  }

  [[nodiscard]] double waited_s() const { return now_s() - start_s_; }

 private:
  double start_s_ = now_s();
};

/// Communicator over all ranks of MPI_COMM_WORLD, by nonblocking calls and polled waits.
///
/// Legal until one rank fails. From then on every call throws PeerFailed with the report: the ranks are no
/// longer in step and MPI cannot be put in order again; what remains is to report to the coupler and to
/// abort (MpiSession). Errors of MPI itself become ComponentLost.
class MpiCommunicator final : public Communicator {
 public:
  explicit MpiCommunicator(SolverContext& context);
  /// Collective, unless broken.
  ~MpiCommunicator() override;

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return size_; }

  void broadcast(std::span<std::byte> data) override;
  void reduce_to_leader(std::span<std::int64_t> values, Reduction reduction) override;
  /// Messages to one peer match that peer's messages to us in the order in which they are listed.
  [[nodiscard]] std::function<void()> start_exchange(std::span<const Message> messages) override;
  [[nodiscard]] std::function<void()> start_send(int peer, std::span<const std::byte> data) override;
  void receive(int peer, std::vector<std::byte>& data) override;

  void report_failure(const FailureReport& report) override;
  [[nodiscard]] bool broken() const { return failure_.has_value(); }

 private:
  class PendingExchange;

  /// @param start  the call of MPI, of that name, on a copy of `data`, which its result replaces
  template <class Start>
  void collective(std::span<std::byte> data, const char* call, const Start& start);
  /// Polls until `request` is complete. @throws PeerFailed if another rank reports a failure meanwhile
  void wait(MPI_Request& request);
  /// The same until poll() is true.
  template <class Poll>
  void wait_until(const Poll& poll);
  void look_for_failure();
  /// While this rank waits: shows it, and on rank 0 looks whether another rank is frozen.
  /// @throws PeerFailed naming that rank
  void look_at_ranks();
  void stop_waiting();
  void throw_if_failed() {
    if (failure_) throw PeerFailed(*failure_);
  }

  MPI_Comm ranks_ = MPI_COMM_NULL;
  MPI_Comm failures_ = MPI_COMM_NULL;  ///< carries failure reports only
  int rank_ = 0;
  int size_ = 1;
  std::optional<FailureReport> failure_;
  std::unique_ptr<HeartbeatBoard> heartbeats_;  ///< null for a single rank
  RankWatch watch_;
};

/// MPI from initialisation to the end of the process; one object per process.
///
/// A rank started by mpirun ends with it, even if mpirun is killed.
class MpiSession {
 public:
  MpiSession();
  /// Ends MPI; after a failure, when a collective end could wait for ever, aborts all ranks.
  ~MpiSession();

  [[nodiscard]] Communicator& ranks() { return *communicator_; }

  /// Exit code with which a failed session aborts. @return `code`, so that main can `return
  /// session.finish(…)`.
  int finish(int code) { return exit_code_ = code; }

 private:
  SolverContext context_;
  std::unique_ptr<MpiCommunicator> communicator_;
  int exit_code_;
};

}  // namespace copepod::fluid
