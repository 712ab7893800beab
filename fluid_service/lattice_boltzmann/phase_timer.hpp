#pragma once

#include <chrono>
#include <map>
#include <string>

#include "recording/timeline.hpp"

namespace copepod::fluid {

/// Phases of a step, in the order in which they happen.
enum class Phase { map, refill, momentum, reduce, halo, wait, reflect, bulk, check, output };

/// Wall time per phase: each call books the time since the previous one, and tells the process's timeline.
class PhaseTimer {
 public:
  void start() { last_ = Clock::now(); }
  void book(Phase phase) {
    const auto now = Clock::now();
    seconds_[static_cast<int>(phase)] += std::chrono::duration<double>(now - last_).count();
    recording::timeline().add(names[static_cast<int>(phase)], last_, now);
    last_ = now;
  }
  [[nodiscard]] std::map<std::string, double> seconds() const {
    std::map<std::string, double> result;
    for (int i = 0; i < phases; ++i) result[names[i]] = seconds_[i];
    return result;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int phases = static_cast<int>(Phase::output) + 1;
  static constexpr const char* names[phases] = {"map",  "refill",  "momentum", "reduce", "halo",
                                                "wait", "reflect", "bulk",     "check",  "output"};
  Clock::time_point last_ = Clock::now();
  double seconds_[phases] = {};
};

}  // namespace copepod::fluid
