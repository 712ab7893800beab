#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace copepod::fluid {

/// Ranks [first, end).
struct RankRange {
  int first = 0;
  int end = 0;

  bool operator==(const RankRange&) const = default;
};

/// How rank 0 reaches every rank by messages of their own: a tree of 31 children per level. A rank relays for those
/// behind it whose numbers differ only in the last digits to base 32, which are 0 in its own: of 32 ranks 31 relay for
/// none, of 1024 all but one for 31 at most.
constexpr int relay_base = 32;

/// The rank from which `rank`, which is not 0, receives.
constexpr int relay_before(int rank) {
  std::int64_t unit = relay_base;
  while (rank % unit == 0) unit *= relay_base;
  return static_cast<int>(rank - rank % unit);
}

/// Those that `rank` sends to, the first rank of each range, with those that they relay to. Ranges follow each other.
inline std::vector<RankRange> relays_after(int rank, int ranks) {
  std::vector<RankRange> result;
  for (std::int64_t unit = 1; rank % (relay_base * unit) == 0 && rank + unit < ranks; unit *= relay_base)
    for (std::int64_t first = rank + unit; first < std::min<std::int64_t>(rank + relay_base * unit, ranks);
         first += unit)
      result.push_back({static_cast<int>(first), static_cast<int>(std::min<std::int64_t>(first + unit, ranks))});
  return result;
}

}  // namespace copepod::fluid
