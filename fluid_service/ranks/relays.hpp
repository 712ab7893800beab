#pragma once

#include <algorithm>
#include <vector>

namespace copepod::fluid {

/// Ranks [first, end).
struct RankRange {
  int first = 0;
  int end = 0;

  bool operator==(const RankRange&) const = default;
};

/// How rank 0 reaches every rank by messages of their own: the ranks of the first group directly, those of any other
/// through the first rank of the group. So a rank relays for a group at most, however many ranks there are, and rank 0
/// sends a message per group, not one per rank.
constexpr int relay_group = 32;

/// The rank from which `rank`, which is not 0, receives.
constexpr int relay_before(int rank) { return rank % relay_group == 0 ? 0 : rank - rank % relay_group; }

/// Those that `rank` sends to, the first rank of each range, with those that they relay to.
inline std::vector<RankRange> relays_after(int rank, int ranks) {
  std::vector<RankRange> result;
  if (rank % relay_group != 0) return result;
  for (int member = rank + 1; member < std::min(rank + relay_group, ranks); ++member)
    result.push_back({member, member + 1});
  if (rank != 0) return result;
  for (int first = relay_group; first < ranks; first += relay_group)
    result.push_back({first, std::min(first + relay_group, ranks)});
  return result;
}

}  // namespace copepod::fluid
