#include "ranks/block_partition.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::fluid {
namespace {

/// Checks that the blocks cover every cell exactly once and that `owner` agrees with `block`.
void expect_exact_cover(const Cell& cells, int ranks, std::size_t bodies = 0) {
  const BlockPartition partition(cells, ranks, bodies);
  ASSERT_EQ(partition.ranks(), ranks);
  std::vector<int> covered(static_cast<std::size_t>(cells[0] * cells[1] * cells[2]), 0);
  for (int rank = 0; rank < ranks; ++rank) {
    const Box box = partition.block(rank);
    ASSERT_GT(box.volume(), 0) << "rank " << rank << " of " << ranks;
    for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
      for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
        for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) {
          ++covered.at(static_cast<std::size_t>((x * cells[1] + y) * cells[2] + z));
          ASSERT_EQ(partition.owner({x, y, z}), rank);
        }
  }
  EXPECT_TRUE(std::all_of(covered.begin(), covered.end(), [](int times) { return times == 1; }));
}

std::string message_of(const Cell& cells, int ranks) {
  try {
    const BlockPartition partition(cells, ranks);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "no error";
}

TEST(BlockPartition, CoversEveryCellExactlyOnceForEveryRankCount) {
  for (int ranks = 1; ranks <= 40; ++ranks) expect_exact_cover({41, 7, 5}, ranks);
  for (int ranks = 1; ranks <= 12; ++ranks) expect_exact_cover({5, 4, 13}, ranks);
  for (const std::size_t bodies : {1U, 10U, 100U, 100000U})
    for (int ranks = 1; ranks <= 40; ++ranks) expect_exact_cover({41, 7, 5}, ranks, bodies);
}

TEST(BlockPartition, GivesTheFirstRankFewerCellsByWhatAllBodiesCostIt) {
  const auto extents = [](std::size_t bodies) {
    const BlockPartition partition({400, 40, 40}, 4, bodies);
    std::vector<std::int64_t> result;
    for (int rank = 0; rank < 4; ++rank) result.push_back(partition.block(rank).extent(0));
    return result;
  };
  EXPECT_EQ(extents(0), (std::vector<std::int64_t>{100, 100, 100, 100}));
  EXPECT_EQ(extents(159), extents(0));                                          // less than a layer of 40 × 40 cells
  EXPECT_EQ(extents(6400), (std::vector<std::int64_t>{70, 110, 110, 110}));     // 40 layers
  EXPECT_EQ(extents(10000000), (std::vector<std::int64_t>{1, 133, 133, 133}));  // no block is empty
}

TEST(BlockPartition, CutsPrimesAlongAnAxisThatIsLongEnough) {
  const BlockPartition partition({4, 6, 50}, 13);
  EXPECT_EQ(partition.grid(), (std::array<int, 3>{1, 1, 13}));
  expect_exact_cover({4, 6, 50}, 13);
}

TEST(BlockPartition, CutsSeveralAxesWhenMoreRanksAreAskedForThanFitOne) {
  const BlockPartition partition({6, 6, 6}, 100 + 8);
  for (const int blocks : partition.grid()) EXPECT_LE(blocks, 6);
  expect_exact_cover({6, 6, 6}, 108);
  expect_exact_cover({3, 3, 3}, 27);  // one cell per rank
}

TEST(BlockPartition, MakesBlocksThatDifferByAtMostOneCellPerAxis) {
  const BlockPartition partition({101, 53, 29}, 12);
  for (int axis = 0; axis < 3; ++axis) {
    std::int64_t shortest = 1000;
    std::int64_t longest = 0;
    for (int rank = 0; rank < 12; ++rank) {
      shortest = std::min(shortest, partition.block(rank).extent(axis));
      longest = std::max(longest, partition.block(rank).extent(axis));
    }
    EXPECT_LE(longest - shortest, 1);
  }
}

TEST(BlockPartition, PrefersCutsNormalToXWhenFacesAreEqual) {
  EXPECT_EQ(BlockPartition({100, 100, 100}, 2).grid(), (std::array<int, 3>{2, 1, 1}));
  EXPECT_EQ(BlockPartition({100, 100, 100}, 4).grid(), (std::array<int, 3>{2, 2, 1}));
}

TEST(BlockPartition, CutsNormalToZOnlyWhenThatFaceIsMuchSmaller) {
  EXPECT_EQ(BlockPartition({50, 50, 200}, 2).grid(), (std::array<int, 3>{2, 1, 1}));
  EXPECT_EQ(BlockPartition({20, 20, 2000}, 2).grid(), (std::array<int, 3>{1, 1, 2}));
}

TEST(BlockPartition, PrefersBalancedBlocksToSmallFaces) {
  // 5 ranks on 6 cells along x would leave four ranks waiting for one that has two cells.
  EXPECT_EQ(BlockPartition({6, 50, 50}, 5).grid(), (std::array<int, 3>{1, 5, 1}));
}

TEST(BlockPartition, SaysHowManyRanksFitADomainWithFewerCellsThanRanks) {
  EXPECT_EQ(message_of({3, 3, 3}, 64), "ranks 64 (the computed domain has only 3×3×3 cells). Use at most 27 ranks.");
}

TEST(BlockPartition, SaysHowManyRanksFitWhenAPrimeIsLongerThanEveryAxis) {
  EXPECT_EQ(message_of({10, 10, 10}, 29),
            "ranks 29 (the computed domain of 10×10×10 cells cannot be cut into so many blocks without an "
            "empty one). "
            "Use 28 ranks.");
}

}  // namespace
}  // namespace copepod::fluid
