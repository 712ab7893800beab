#include "ranks/relays.hpp"

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

TEST(Relays, ReachEveryRankOnceAndInRangesThatTheReceiverPassesOn) {
  for (const int ranks : {1, 2, 31, 32, 33, 64, 65, 200, 1000}) {
    std::vector<int> reached(static_cast<std::size_t>(ranks), 0);
    for (int rank = 0; rank < ranks; ++rank) {
      int end = rank + 1;
      for (const RankRange& range : relays_after(rank, ranks)) {
        EXPECT_EQ(range.first, end);  // they follow each other, so that what they need lies side by side
        end = range.end;
        EXPECT_EQ(relay_before(range.first), rank);
        ++reached[static_cast<std::size_t>(range.first)];
        const auto passed_on = relays_after(range.first, ranks);
        EXPECT_EQ(range.end, rank > 0 || passed_on.empty() ? range.first + 1 : passed_on.back().end);
      }
      if (rank == 0) {
        EXPECT_EQ(end, ranks);
      }
    }
    EXPECT_EQ(reached[0], 0);
    for (int rank = 1; rank < ranks; ++rank) EXPECT_EQ(reached[static_cast<std::size_t>(rank)], 1) << rank;
  }
}

TEST(Relays, GiveNoRankButTheFirstMoreMessagesForMoreRanks) {
  for (const int ranks : {64, 1000, 100000}) {
    EXPECT_LE(relays_after(0, ranks).size(), static_cast<std::size_t>(relay_group + ranks / relay_group));
    for (int rank = 1; rank < ranks; ++rank) ASSERT_LT(relays_after(rank, ranks).size(), std::size_t{relay_group});
  }
}

}  // namespace
}  // namespace copepod::fluid
