#include "run/stop_signal.hpp"

#include <csignal>

namespace copepod::coupler {
namespace {

std::atomic<int> received{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not lock");

void remember(int signal) { received.store(signal); }

}  // namespace

const std::atomic<int>& stop_signal() { return received; }

void watch_signals() {
  received.store(0);
  struct sigaction action {};
  action.sa_handler = remember;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // Nobody reads our events any more: the run goes on, its files are what counts.
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace copepod::coupler
