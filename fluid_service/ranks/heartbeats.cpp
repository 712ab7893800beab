#include "ranks/heartbeats.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <iostream>
#include <mutex>
#include <new>

#include "contract/errors.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

namespace {

constexpr std::chrono::milliseconds beat_every{200};

}  // namespace

/// One cache line per rank, written by that rank only.
struct alignas(64) HeartbeatBoard::Place {
  int rank = 0;
  std::atomic<std::uint64_t> beats{0};
  std::atomic<std::uint64_t> progress{0};
  std::atomic<bool> waits{false};
};

HeartbeatBoard::HeartbeatBoard(MPI_Comm ranks, const SolverContext& context) : context_(context) {
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "processes share these");
  int rank = 0;
  MPI_Comm_rank(ranks, &rank);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(ranks, MPI_COMM_TYPE_SHARED, rank, MPI_INFO_NULL, &machine);
  void* memory = nullptr;
  const int result = MPI_Win_allocate_shared(sizeof(Place), 1, MPI_INFO_NULL, machine, &memory, &window_);
  if (result != MPI_SUCCESS || memory == nullptr) {  // the ranks are not ready for exceptions yet
    std::cerr << "error: the ranks' shared memory cannot be made (/dev/shm is full, or files may not grow). Free space "
                 "there, or raise ulimit -f."
              << std::endl;
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(ExitCode::storage_failed));
  }
  own_ = new (memory) Place{.rank = rank};
  MPI_Barrier(machine);  // all entries are initialised before rank 0 reads them
  if (rank == 0) find_others(machine);
  MPI_Comm_free(&machine);
  if (rank != 0) thread_ = std::jthread([this](const std::stop_token& stop) { beat(stop); });
}

void HeartbeatBoard::free() {
  thread_ = {};
  MPI_Win_free(&window_);
}

void HeartbeatBoard::find_others(MPI_Comm machine) {
  int members = 0;
  MPI_Comm_size(machine, &members);
  for (int member = 1; member < members; ++member) {  // 0 is rank 0: the order is that of the ranks
    MPI_Aint size = 0;
    int unit = 0;
    void* memory = nullptr;
    MPI_Win_shared_query(window_, member, &size, &unit, &memory);
    others_.push_back(static_cast<const Place*>(memory));
    readings_.push_back({.rank = others_.back()->rank});
  }
}

void HeartbeatBoard::beat(const std::stop_token& stop) {
  block_signals();
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  while (!stop.stop_requested()) {
    own_->progress.store(context_.progress(), std::memory_order_relaxed);
    own_->beats.fetch_add(1, std::memory_order_relaxed);
    stopped.wait_for(lock, stop, beat_every, [] { return false; });
  }
}

void HeartbeatBoard::show_waiting(bool waits) { own_->waits.store(waits, std::memory_order_relaxed); }

std::span<const Heartbeat> HeartbeatBoard::read() {
  for (std::size_t i = 0; i < others_.size(); ++i) {
    readings_[i].beats = others_[i]->beats.load(std::memory_order_relaxed);
    readings_[i].progress = others_[i]->progress.load(std::memory_order_relaxed);
    readings_[i].waits = others_[i]->waits.load(std::memory_order_relaxed);
  }
  return readings_;
}

}  // namespace copepod::fluid
