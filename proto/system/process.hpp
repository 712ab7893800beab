#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <pthread.h>
#include <random>
#include <string>
#include <unistd.h>

namespace copepod {

/// Name of this machine, for reports.
inline std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

/// Of the monotonic clock [s].
inline double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Unlike that of any other process.
inline std::uint64_t random_number() {
  std::random_device device;
  return (std::uint64_t{device()} << 32U) | device();
}

/// Rank of this process according to the launcher of an MPI program (mpirun, srun, …), before MPI is initialised.
/// @return nothing without a launcher
inline std::optional<int> launched_rank() {
  for (const char* variable : {"PMIX_RANK", "PMI_RANK"})
    if (const char* rank = std::getenv(variable)) return std::atoi(rank);
  return std::nullopt;
}

/// Keeps signals from this thread: they belong to the one that computes.
inline void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

/// The text with `?` for control characters, line feeds too: it may hold the words of strangers or of files from
/// elsewhere, which must not command a terminal or pass for lines of ours.
inline std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

}  // namespace copepod
