#pragma once

#include <functional>
#include <memory>

#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Ranks that are threads of this process: rank 0 is the thread that makes this object, each other rank a thread that
/// runs a function. Their communicators keep the contract of Communicator with these means:
///
/// * A message is copied once, from the sender's buffer to the receiver's, by whichever rank waits for it first: a rank
///   that is late leaves the copies to the one that waits for it. Collective calls copy what they send, and do not wait
///   for its receivers.
/// * A wait polls for `spin_s`, giving the core to any other thread between two polls, and then sleeps until another
///   rank posts or copies its message, or fails (docs/decisions/in_process.md has the measurement).
class ThreadRanks {
 public:
  static constexpr double spin_s = 50e-6;

  /// @param size     number of ranks
  /// @param leader   context of rank 0; outlives this object
  /// @param follow   what every other rank runs, with its communicator; must not throw
  /// @throws ComponentLost if the system does not grant so many threads
  ThreadRanks(int size, SolverContext& leader, const std::function<void(Communicator&)>& follow);
  /// Waits until every `follow` has returned; that they do so is the caller's care.
  ~ThreadRanks();

  /// Communicator of rank 0.
  [[nodiscard]] Communicator& leader();

 private:
  class Channel;
  class Posting;
  class Rank;
  class Team;

  std::unique_ptr<Team> team_;
};

}  // namespace copepod::fluid
