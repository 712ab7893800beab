#include "ranks/relays.hpp"

#include <utility>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

TEST(Relays, ReachEveryRankOnceAndInRangesThatTheReceiverPassesOn) {
  for (const int ranks : {1, 2, 31, 32, 33, 64, 65, 200, 1024, 1025, 3000}) {
    std::vector<int> reached(static_cast<std::size_t>(ranks), 0);
    for (int rank = 0; rank < ranks; ++rank) {
      int end = rank + 1;
      for (const RankRange& range : relays_after(rank, ranks)) {
        EXPECT_EQ(range.first, end);  // they follow each other, so that what they need lies side by side
        end = range.end;
        EXPECT_EQ(relay_before(range.first), rank);
        ++reached[static_cast<std::size_t>(range.first)];
        const auto passed_on = relays_after(range.first, ranks);
        EXPECT_EQ(range.end, passed_on.empty() ? range.first + 1 : passed_on.back().end);
      }
      if (rank == 0) {
        EXPECT_EQ(end, ranks);
      }
    }
    EXPECT_EQ(reached[0], 0);
    for (int rank = 1; rank < ranks; ++rank) EXPECT_EQ(reached[static_cast<std::size_t>(rank)], 1) << rank;
  }
}

TEST(Relays, AreFewerThanThirtyTwoPerLevelAndNoneForMostRanks) {
  for (const auto& [ranks, levels] : {std::pair{32, 1U}, {1000, 2U}, {10000, 3U}, {100000, 4U}}) {
    int relaying = 0;
    for (int rank = 0; rank < ranks; ++rank) {
      const auto relays = relays_after(rank, ranks);
      ASSERT_LE(relays.size(), 31U * levels);
      relaying += relays.empty() ? 0 : 1;
      if (rank % 1024 != 0) {
        ASSERT_LE(relays.size(), 31U);
      }
    }
    EXPECT_LE(relaying, ranks / 32 + 1);
  }
}

}  // namespace
}  // namespace copepod::fluid
