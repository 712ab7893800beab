#include "run/signals.hpp"

#include <csignal>

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

}  // namespace copepod::coupler
