#include <vector>

#include <gtest/gtest.h>

#include "ranks/block_partition.hpp"

namespace copepod::fluid {
namespace {

/// Index of every cell that the pieces of a box hold, in their order.
std::vector<std::int64_t> cells_of_pieces(const Box& box, std::int64_t most_cells) {
  std::vector<std::int64_t> cells;
  for_each_piece(box, most_cells, [&](const Box& piece) {
    EXPECT_LE(piece.volume(), most_cells);
    for (std::int64_t x = piece.low[0]; x < piece.high[0]; ++x)
      for (std::int64_t y = piece.low[1]; y < piece.high[1]; ++y)
        for (std::int64_t z = piece.low[2]; z < piece.high[2]; ++z) cells.push_back((x * 100 + y) * 100 + z);
  });
  return cells;
}

TEST(Pieces, TogetherAreTheBoxInOrder) {
  const Box box = {{2, 3, 4}, {7, 6, 11}};
  const std::vector<std::int64_t> whole = cells_of_pieces(box, box.volume());
  EXPECT_EQ(whole.size(), 5U * 3U * 7U);
  for (const std::int64_t most_cells : {1, 2, 7, 20, 50}) EXPECT_EQ(cells_of_pieces(box, most_cells), whole);
}

TEST(Pieces, OfAnEmptyBoxAreNone) { EXPECT_TRUE(cells_of_pieces({{1, 1, 1}, {1, 5, 5}}, 4).empty()); }

}  // namespace
}  // namespace copepod::fluid
