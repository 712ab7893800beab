#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
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

  virtual void broadcast(std::span<std::byte> data) = 0;  ///< from rank 0

  enum class Reduction { sum, max };
  /// Sums are exact modulo 2⁶⁴. The result is on rank 0 only.
  virtual void reduce_to_leader(std::span<std::int64_t> values, Reduction reduction) = 0;
  void sum_to_leader(std::span<std::int64_t> values) { reduce_to_leader(values, Reduction::sum); }
  void sum_to_all(std::span<std::int64_t> values) { reduce_to_all(values, Reduction::sum); }
  void max_to_all(std::span<std::int64_t> values) { reduce_to_all(values, Reduction::max); }

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
  void reduce_to_all(std::span<std::int64_t> values, Reduction reduction) {
    reduce_to_leader(values, reduction);
    broadcast(std::as_writable_bytes(values));
  }

  SolverContext& context_;
};

/// One rank, no messages: for a process without others, and for unit tests.
class SelfCommunicator : public Communicator {
 public:
  using Communicator::Communicator;
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int size() const override { return 1; }
  void broadcast(std::span<std::byte>) override {}
  void reduce_to_leader(std::span<std::int64_t>, Reduction) override {}
  [[nodiscard]] std::function<void()> start_exchange(std::span<const Message>) override {
    return [] {};
  }
  [[nodiscard]] std::function<void()> start_send(int, std::span<const std::byte>) override {
    return [] {};
  }
  void receive(int, std::vector<std::byte>&) override {}
  void report_failure(const FailureReport&) override {}
};

}  // namespace copepod::fluid
