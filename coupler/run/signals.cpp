#include "run/signals.hpp"

#include <csignal>

namespace copepod::coupler {
namespace {

std::atomic<RunSignals*> watched{nullptr};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<RunSignals*>::is_always_lock_free,
              "a signal handler may not lock");

void stop(RunSignals& signals, int signal) {
  std::signal(signal, SIG_DFL);
  signals.stop.store(signal);
}

void on_stop(int signal) {
  if (RunSignals* const signals = watched.load()) stop(*signals, signal);
}

void on_sigterm(int signal) {
  RunSignals* const signals = watched.load();
  if (signals == nullptr) return;
  const bool waits = signals->sigterm_waits_for_checkpoint.load();
  // The second one does not wait any longer.
  if (!waits || signals->checkpoint.exchange(signal) == signal) stop(*signals, signal);
}

void on_checkpoint(int signal) {
  int none = 0;
  if (RunSignals* const signals = watched.load())
    signals->checkpoint.compare_exchange_strong(none, signal);  // must not hide a SIGTERM
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

SignalWatch::SignalWatch(RunSignals& signals) {
  watched.store(&signals);
  handle(SIGINT, on_stop);
  handle(SIGTERM, on_sigterm);
  handle(SIGUSR1, on_checkpoint);
  // A closed event stream must not end the run: its files are the result.
  std::signal(SIGPIPE, SIG_IGN);
}

SignalWatch::~SignalWatch() { watched.store(nullptr); }

}  // namespace copepod::coupler
