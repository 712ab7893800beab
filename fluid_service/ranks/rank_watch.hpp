#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace copepod::fluid {

/// What one rank showed of itself at some moment.
struct PulseReading {
  int rank = 0;
  std::uint64_t beats = 0;     ///< grows as long as the process runs
  std::uint64_t progress = 0;  ///< grows when its solver shows that it moves on
  bool waits = false;          ///< its solver has been waiting for other ranks for a while
};

/// What rank 0, which waits, concludes about the others.
struct RankVerdict {
  std::optional<int> frozen;  ///< a rank without a sign of life
  int awaited = 0;            ///< the first rank that does not wait itself; 0: none
  bool progressed = false;    ///< some solver moved on since the last look
};

/// Rank 0's memory of the other ranks' pulses; times are seconds of one monotonic clock.
class RankWatch {
 public:
  static constexpr double silence_s = 2.5;  ///< a process that does not beat for so long is frozen
  static constexpr double absence_s = 1.0;  ///< without a look for so long all clocks start anew

  /// @param readings  the same ranks in the same order every time
  RankVerdict look(std::span<const PulseReading> readings, double now_s) {
    const bool was_away = now_s - last_look_s_ > absence_s || sightings_.size() != readings.size();
    last_look_s_ = now_s;
    sightings_.resize(readings.size());
    RankVerdict verdict;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const PulseReading& reading = readings[i];
      Sighting& sighting = sightings_[i];
      if (was_away || reading.beats != sighting.beats) sighting.alive_s = now_s;
      if (!was_away && reading.progress != sighting.progress) verdict.progressed = true;
      sighting.beats = reading.beats;
      sighting.progress = reading.progress;
      if (now_s - sighting.alive_s > silence_s && !verdict.frozen) verdict.frozen = reading.rank;
      if (!reading.waits && verdict.awaited == 0) verdict.awaited = reading.rank;
    }
    return verdict;
  }

 private:
  struct Sighting {
    std::uint64_t beats = 0;
    std::uint64_t progress = 0;
    double alive_s = 0.0;
  };
  double last_look_s_ = -1e300;
  std::vector<Sighting> sightings_;
};

}  // namespace copepod::fluid
