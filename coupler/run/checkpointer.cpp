#include "run/checkpointer.hpp"

#include <algorithm>
#include <csignal>
#include <string>

#include <spdlog/spdlog.h>

#include "contract/errors.hpp"

namespace copepod::coupler {

namespace {

std::atomic<RunSignals*> watched{nullptr};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<RunSignals*>::is_always_lock_free,
              "a signal handler may not lock");

void on_stop(int signal) {
  RunSignals* const signals = watched.load();
  if (signals == nullptr) return;
  const bool waits = signals->stop_waits_for_checkpoint.load();
  const int former = waits ? signals->checkpoint.exchange(signal) : signal;
  if (former == 0 || former == SIGUSR1) return;
  std::signal(signal, SIG_DFL);
  signals->stop.store(signal);
}

void on_checkpoint(int signal) {
  int none = 0;
  if (RunSignals* const signals = watched.load())
    signals->checkpoint.compare_exchange_strong(none, signal);  // must not hide one that stops
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

/// Whether a signal that a checkpoint answers ends the run then.
bool stops(int signal) { return signal != 0 && signal != SIGUSR1; }

}  // namespace

SignalWatch::SignalWatch(RunSignals& signals) {
  watched.store(&signals);
  handle(SIGINT, on_stop);
  handle(SIGTERM, on_stop);
  if (std::signal(SIGHUP, SIG_IGN) != SIG_IGN) handle(SIGHUP, on_stop);
  handle(SIGUSR1, on_checkpoint);
  // A closed event stream must not end the run: its files are the result. A file that may not grow is a full disk.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

SignalWatch::~SignalWatch() { watched.store(nullptr); }

Checkpointer::Checkpointer(const CheckpointStore& store, Components& components, Ability able, const Case& the_case,
                           std::int64_t first_step, RunSignals& signals, Events& events)
    : store_(store),
      components_(components),
      able_(able),
      first_step_(first_step),
      schedule_(the_case.output.checkpoint_every_steps, the_case.output.checkpoint_every_wall_s, first_step,
                CheckpointSchedule::Clock::now()),
      expected_bytes_(static_cast<std::uintmax_t>(population_bytes(the_case.fluid))),
      signals_(signals),
      events_(events) {
  signals_.stop_waits_for_checkpoint.store(able_ == Ability::saves);
}

bool Checkpointer::wants_pause(std::int64_t step) {
  if (const int signal = signals_.stop.load(); signal != 0) throw Interrupted(signal, step);
  if (able_ == Ability::none) return false;
  if (step == first_step_) {
    if (const int signal = signals_.checkpoint.load(); stops(signal)) throw Interrupted(signal, step);
    return false;  // SIGUSR1 waits for the next step
  }
  return signals_.checkpoint.load() != 0 || schedule_.due(step, CheckpointSchedule::Clock::now());
}

void Checkpointer::write(const SolversByFile& solvers, std::int64_t step, const std::function<CouplerState()>& state) {
  events_.phase("checkpointing");
  bool is_written = true;
  try {
    commit(solvers, state);
  } catch (const StorageError& error) {
    const std::string text = "No checkpoint of step " + std::to_string(step) + ": " + error.what();
    spdlog::error(text);
    events_.notice(text);
    is_written = false;
  }
  schedule_.written(step, CheckpointSchedule::Clock::now());
  // A request that came while it was written is answered by it.
  if (const int signal = signals_.checkpoint.exchange(0); stops(signal)) {
    throw is_written ? Interrupted(signal, step, "Continue from its checkpoint with --resume.")
                     : Interrupted(signal, step);
  }
  events_.phase("running");
}

/// Checks the disk first, to leave some room for other programs; if it fills up meanwhile, the solvers
/// report that.
void Checkpointer::commit(const SolversByFile& solvers, const std::function<CouplerState()>& state) {
  const std::uintmax_t needed = std::max(store_.newest_bytes(), expected_bytes_) + (std::uintmax_t{1} << 20);
  if (const std::uintmax_t available = free_bytes(store_.folder().parent_path()); available < needed) {
    throw StorageError(std::to_string(available) + " bytes are free where a checkpoint takes about " +
                       std::to_string(needed) + " (the disk is nearly full). Free some space; the run continues.");
  }
  const CouplerState own = state();
  store_.prepare(solvers, own);
  components_.stay_in_touch_during([&] { store_.commit(own.step); });
  spdlog::info("checkpoint of step {}", own.step);
}

}  // namespace copepod::coupler
