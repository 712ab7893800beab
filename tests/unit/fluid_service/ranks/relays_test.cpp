#include <numeric>
#include <utility>

#include <gtest/gtest.h>

#include "lattice_boltzmann/bodies/nearby_bodies.hpp"

namespace copepod::fluid {
namespace {

constexpr int numbers[] = {1, 2, 32, 33, 34, 65, 200, 1057, 1058, 3000, 34000};

TEST(Relays, ReachEveryRankOnce) {
  for (const int ranks : numbers) {
    std::vector<int> reached = ranks_behind(0, ranks);
    std::ranges::sort(reached);
    std::vector<int> all(static_cast<std::size_t>(ranks));
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(reached, all);
  }
}

TEST(Relays, ReceiveInOnePieceWhatTheyPassOn) {
  for (const int ranks : numbers)
    for (int rank = 0; rank < std::min(ranks, 200); ++rank) {
      const std::vector<int> behind = ranks_behind(rank, ranks);
      ASSERT_EQ(behind.front(), rank);
      std::size_t end = 1;
      for (const Relay& relay : relays_after(behind)) {
        EXPECT_EQ(relay_before(relay.rank), rank);
        EXPECT_EQ(relay.first, end);
        end = relay.end;
        const auto begin = behind.begin();
        const std::vector<int> piece(begin + static_cast<std::ptrdiff_t>(relay.first),
                                     begin + static_cast<std::ptrdiff_t>(relay.end));
        EXPECT_EQ(piece, ranks_behind(relay.rank, ranks));
      }
      EXPECT_EQ(end, behind.size());
    }
}

TEST(Relays, AreTheFirstRanksAndSendToThirtyTwoEach) {
  for (const int ranks : numbers)
    for (int rank = 0; rank < ranks; ++rank) {
      const auto relays = relays_after(ranks_behind(rank, ranks));
      ASSERT_LE(relays.size(), 32U);
      ASSERT_EQ(relays.empty(), rank > (ranks - 2) / 32 || ranks == 1);
    }
}

TEST(Relays, PassOnAFewTimesOnly) {
  for (const auto& [ranks, levels] : {std::pair{33, 1}, {1057, 2}, {33825, 3}, {100000, 4}}) {
    int level = 0;
    for (int rank = ranks - 1; rank != 0; rank = relay_before(rank)) ++level;
    EXPECT_EQ(level, levels);
  }
}

}  // namespace
}  // namespace copepod::fluid
