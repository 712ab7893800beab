#pragma once

#include <csignal>
#include <pthread.h>

namespace copepod {

/// Keeps signals from this thread: they belong to the one that computes.
inline void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

}  // namespace copepod
