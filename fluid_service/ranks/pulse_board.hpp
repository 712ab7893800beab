#pragma once

#include <condition_variable>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include <mpi.h>

#include "ranks/rank_watch.hpp"

namespace copepod::fluid {

/// Memory that all ranks of one machine share, in which each shows that it lives and whether it waits. It is
/// read and written without a message, so also while ranks compute, freeze or hang. Ranks on other machines
/// than rank 0's do not appear on it.
class PulseBoard {
 public:
  /// Collective. Every rank but 0 starts a thread that beats and never calls MPI; the coupler's pings look
  /// after rank 0.
  explicit PulseBoard(MPI_Comm ranks);
  PulseBoard(const PulseBoard&) = delete;
  PulseBoard& operator=(const PulseBoard&) = delete;
  /// Ends the thread; leaves the memory to the end of the process unless `free` was called.
  ~PulseBoard();

  /// Collective: gives the memory back; the last call.
  void free();

  /// This rank's solver waits for others, or does so no longer.
  void show_waiting(bool waits);

  /// The other ranks on rank 0's machine; on rank 0.
  std::span<const PulseReading> read();

 private:
  struct Pulse;
  void find_others(MPI_Comm machine, MPI_Comm ranks);
  void beat();
  void stop_beating();

  MPI_Win window_ = MPI_WIN_NULL;
  Pulse* own_ = nullptr;
  std::vector<const Pulse*> others_;
  std::vector<PulseReading> readings_;  ///< of `others_`
  std::mutex mutex_;
  std::condition_variable leave_;
  bool leaving_ = false;
  std::thread thread_;
};

}  // namespace copepod::fluid
