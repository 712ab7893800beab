#include "run/signals.hpp"

#include <csignal>

namespace copepod::coupler {
namespace {

RunSignals signals;
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "a signal handler may not lock");

void on_stop(int signal) {
  std::signal(signal, SIG_DFL);
  signals.stop.store(signal);
}

void on_sigterm(int signal) {
  if (!signals.sigterm_waits_for_checkpoint.load()) {
    on_stop(signal);
  } else if (signals.checkpoint.exchange(signal) == signal) {
    on_stop(signal);  // asked twice: do not wait any longer
  }
}

void on_checkpoint(int signal) {
  int none = 0;
  signals.checkpoint.compare_exchange_strong(none, signal);  // must not hide a SIGTERM
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

RunSignals& process_signals() { return signals; }

void watch_signals() {
  signals.stop.store(0);
  signals.checkpoint.store(0);
  signals.sigterm_waits_for_checkpoint.store(false);
  handle(SIGINT, on_stop);
  handle(SIGTERM, on_sigterm);
  handle(SIGUSR1, on_checkpoint);
  // The reader of our events is gone: the run continues, since its files matter.
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace copepod::coupler
