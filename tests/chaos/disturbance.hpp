#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

namespace copepod::chaos {

/// What may happen to a message on its way.
enum class Disturbance { none, drop, repeat, replay, delay, reorder, truncate, corrupt, cut };

inline constexpr std::array kDisturbances = {Disturbance::drop,    Disturbance::repeat,  Disturbance::replay,
                                             Disturbance::delay,   Disturbance::reorder, Disturbance::truncate,
                                             Disturbance::corrupt, Disturbance::cut};

constexpr std::string_view name_of(Disturbance kind) {
  constexpr std::array<std::string_view, 9> names = {"none",    "drop",     "repeat",  "replay", "delay",
                                                     "reorder", "truncate", "corrupt", "cut"};
  return names[static_cast<std::size_t>(kind)];
}

/// Which messages are disturbed, and how.
struct ChaosPlan {
  std::uint64_t seed = 1;
  double share = 0.1;       ///< of all messages that is disturbed
  double cut_share = 0.01;  ///< of the disturbed messages, with which the connection breaks
  std::vector<Disturbance> kinds{kDisturbances.begin(), kDisturbances.end()};  ///< equally often, but for cuts
};

/// Draws the fate of one message after the other; the same seed gives the same fates.
class Fates {
 public:
  explicit Fates(const ChaosPlan& plan) : plan_(plan), random_(plan.seed) {
    for (const Disturbance kind : plan_.kinds) (kind == Disturbance::cut ? cuts_ : others_).push_back(kind);
  }

  Disturbance next() {
    if (uniform() >= plan_.share) return Disturbance::none;
    const bool cuts = others_.empty() || (!cuts_.empty() && uniform() < plan_.cut_share);
    const std::vector<Disturbance>& choice = cuts ? cuts_ : others_;
    return choice.empty() ? Disturbance::none : choice[below(choice.size())];
  }

  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  std::size_t below(std::size_t limit) { return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_); }

 private:
  ChaosPlan plan_;
  std::mt19937_64 random_;
  std::vector<Disturbance> cuts_, others_;
};

}  // namespace copepod::chaos
