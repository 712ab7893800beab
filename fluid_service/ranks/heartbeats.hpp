#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

#include <mpi.h>

#include "contract/solver_context.hpp"

namespace copepod::fluid {

/// What one rank showed of itself at some moment.
struct Heartbeat {
  int rank = 0;
  std::uint64_t beats = 0;     ///< grows as long as the process runs
  std::uint64_t progress = 0;  ///< grows when its solver shows that it moves on
  bool waits = false;          ///< its solver has been waiting for other ranks for a while
};

/// What rank 0, which waits, concludes about the others.
struct RankVerdict {
  std::optional<int> frozen;  ///< a rank without a sign of life
  int awaited = 0;            ///< the first rank that does not wait itself; 0: none
  bool progressed = false;    ///< some solver moved on since the last look
};

/// What rank 0 remembers of the other ranks' heartbeats; times are seconds of one monotonic clock.
class RankWatch {
 public:
  static constexpr double silence_s = 2.5;  ///< a process that does not beat for so long is frozen
  static constexpr double absence_s = 1.0;  ///< without a look for so long all clocks start anew

  /// @param readings  the same ranks in the same order every time
  RankVerdict look(std::span<const Heartbeat> readings, double now_s) {
    const bool was_away = now_s - last_look_s_ > absence_s || sightings_.size() != readings.size();
    last_look_s_ = now_s;
    sightings_.resize(readings.size());
    RankVerdict verdict;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const Heartbeat& reading = readings[i];
      Sighting& sighting = sightings_[i];
      if (was_away || reading.beats != sighting.beats) sighting.alive_s = now_s;
      if (!was_away && reading.progress != sighting.progress) verdict.progressed = true;
      sighting.beats = reading.beats;
      sighting.progress = reading.progress;
      if (now_s - sighting.alive_s > silence_s && !verdict.frozen) verdict.frozen = reading.rank;
      if (!reading.waits && verdict.awaited == 0) verdict.awaited = reading.rank;
    }
    return verdict;
  }

 private:
  struct Sighting {
    std::uint64_t beats = 0;
    std::uint64_t progress = 0;
    double alive_s = 0.0;
  };
  double last_look_s_ = -1e300;
  std::vector<Sighting> sightings_;
};

/// Memory that all ranks of one machine share, in which each rank shows its heartbeat and whether it waits.
/// It is read and written without a message, hence also while ranks compute, freeze or hang. Ranks on other
/// machines than rank 0's do not appear on it.
class HeartbeatBoard {
 public:
  /// Collective. Every rank but 0 starts a thread that beats and never calls MPI; the coupler's pings
  /// cover rank 0.
  /// @param context  whose progress the thread shows; outlives this object
  HeartbeatBoard(MPI_Comm ranks, const SolverContext& context);

  /// Collective: ends the thread and gives the memory back, which is there to the end of the process otherwise; the
  /// last call.
  void free();

  /// This rank's solver waits for others, or does so no longer.
  void show_waiting(bool waits);

  /// The other ranks on rank 0's machine; on rank 0.
  std::span<const Heartbeat> read();

 private:
  struct Place;
  void find_others(MPI_Comm machine);
  void beat(const std::stop_token& stop);

  const SolverContext& context_;
  MPI_Win window_ = MPI_WIN_NULL;
  Place* own_ = nullptr;
  std::vector<const Place*> others_;
  std::vector<Heartbeat> readings_;  ///< of `others_`
  std::jthread thread_;              ///< last: it ends before what it uses
};

}  // namespace copepod::fluid
