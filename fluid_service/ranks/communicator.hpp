#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <thread>
#include <vector>

#include "contract/errors.hpp"
#include "contract/solver_context.hpp"

namespace copepod::fluid {

/// The ranks of the fluid: processes (MpiCommunicator) or threads (ThreadRanks). All MPI calls of the project are
/// behind this class.
///
/// Every wait polls with a back-off that soon sleeps, so a waiting rank does not burn its core, and watches
/// for a failure report: a rank that throws calls `report_failure`, and every other rank's wait then throws
/// PeerFailed with that report instead of deadlocking.
class Communicator {
 public:
  /// @param context  of the solver on this rank; outlives the communicator
  explicit Communicator(SolverContext& context) : context_(context) {}
  virtual ~Communicator() = default;
  /// Progress, stop request and timeline of this rank's solver.
  [[nodiscard]] SolverContext& context() const { return context_; }
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;

  virtual void broadcast(std::span<std::byte> data) = 0;           ///< from rank 0
  virtual void sum_to_leader(std::span<std::int64_t> values) = 0;  ///< exact; result on rank 0 only
  virtual void sum_to_all(std::span<std::int64_t> values) = 0;     ///< exact
  virtual void max_to_all(std::span<std::int64_t> values) = 0;

  /// One message to and one from each named peer; both sides name each other and have the same sizes.
  struct Message {
    int peer = 0;
    std::span<const std::byte> send;
    std::span<std::byte> receive;
  };
  /// Starts the exchange; the returned function waits for completion. Buffers must live until then.
  [[nodiscard]] virtual std::function<void()> start_exchange(std::span<const Message> messages) = 0;

  /// Starts a message of any size to `peer`, which receives it; the returned function waits until `data` is no longer
  /// needed. Messages to one peer arrive in the order in which they are started.
  [[nodiscard]] virtual std::function<void()> start_send(int peer, std::span<const std::byte> data) = 0;
  /// Waits for the next message that `peer` sends by start_send.
  /// @param data  overwritten, whatever its size
  virtual void receive(int peer, std::vector<std::byte>& data) = 0;

  /// Reports to all other ranks why this one failed; called once by the code around the solver, which must
  /// still be alive: its messages may be under way. Afterwards the communicator is broken and every call
  /// throws PeerFailed.
  virtual void report_failure(const FailureReport& report) = 0;

 private:
  SolverContext& context_;
};

/// One rank, no messages: for a process without others, and for unit tests.
class SelfCommunicator : public Communicator {
 public:
  using Communicator::Communicator;
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int size() const override { return 1; }
  void broadcast(std::span<std::byte>) override {}
  void sum_to_leader(std::span<std::int64_t>) override {}
  void sum_to_all(std::span<std::int64_t>) override {}
  void max_to_all(std::span<std::int64_t>) override {}
  [[nodiscard]] std::function<void()> start_exchange(std::span<const Message>) override {
    return [] {};
  }
  [[nodiscard]] std::function<void()> start_send(int, std::span<const std::byte>) override {
    return [] {};
  }
  void receive(int, std::vector<std::byte>&) override {}
  void report_failure(const FailureReport&) override {}
};

/// Pauses between two polls of a wait: yields at first, then sleeps ever longer.
///
/// docs/decisions/waiting_ranks_sleep.md has the measurement behind the figures.
class Backoff {
 public:
  static constexpr double spin_s = 100e-6;
  static constexpr double longest_pause_s = 1e-3;

  Backoff() : start_s_(now_s()) {}

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
  static double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  double start_s_;
};

}  // namespace copepod::fluid
