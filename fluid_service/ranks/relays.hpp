#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace copepod::fluid {

/// How rank 0 reaches every rank by messages of their own: rank r sends to 32 r + 1 … 32 r + 32. One rank of 32 relays,
/// and these are the first ones: where there are many bodies they have fewer cells (block_partition.hpp), and receive
/// while the others compute.
constexpr int relay_base = 32;

/// The rank from which `rank`, which is not 0, receives.
constexpr int relay_before(int rank) { return (rank - 1) / relay_base; }

/// `rank` and those that it relays to, each followed by the ones behind it.
inline std::vector<int> ranks_behind(int rank, int ranks) {
  std::vector<int> result = {rank};
  const std::int64_t first = std::int64_t{relay_base} * rank + 1;
  for (std::int64_t next = first; next < std::min<std::int64_t>(first + relay_base, ranks); ++next) {
    const std::vector<int> behind = ranks_behind(static_cast<int>(next), ranks);
    result.insert(result.end(), behind.begin(), behind.end());
  }
  return result;
}

/// A rank that is sent to directly, and the places in ranks_behind of it and those behind it: [first, end).
struct Relay {
  int rank = 0;
  std::size_t first = 0;
  std::size_t end = 0;
};

/// @param behind  ranks_behind of a rank
inline std::vector<Relay> relays_after(const std::vector<int>& behind) {
  std::vector<Relay> result;
  for (std::size_t place = 1; place < behind.size(); ++place) {
    if (relay_before(behind[place]) == behind.front()) result.push_back({behind[place], place, place});
    result.back().end = place + 1;
  }
  return result;
}

}  // namespace copepod::fluid
