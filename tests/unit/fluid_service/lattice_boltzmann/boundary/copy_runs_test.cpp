#include "lattice_boltzmann/boundary/copy_runs.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

TEST(CopyRuns, MergesCopiesOfEqualStrideAndCopiesThemAll) {
  CopyRuns copies;
  for (int i = 0; i < 4; ++i) copies.add(10 + i, i);          // one run of stride 1
  for (int i = 0; i < 3; ++i) copies.add(20 + 5 * i, 5 * i);  // one run of stride 5
  copies.add(40, 3, 0.5);                                     // another addition: a run of its own
  EXPECT_EQ(copies.runs().size(), 3U);
  EXPECT_EQ(copies.values(), 8);
  std::vector<double> values(50, 0.0);
  for (int i = 0; i < 16; ++i) values[static_cast<std::size_t>(i)] = i;
  values[10] = values[11] = values[12] = values[13] = -1.0;
  copies.copy(values.data());
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(values[10 + i], static_cast<double>(i));
  EXPECT_EQ(values[25], 5.0);
  EXPECT_EQ(values[40], 3.5);
}

TEST(CopyRuns, MergesWhatIsPackedFromARow) {
  CopyRuns row;
  for (int i = 0; i < 100; ++i) row.add(40 + i);
  EXPECT_EQ(row.runs().size(), 1U);
  EXPECT_EQ(row.values(), 100);
}

TEST(CopyRuns, UnpackPutsWhatPackCollectedIntoTheTargets) {
  CopyRuns send;
  CopyRuns receive;
  const int sources[] = {3, 4, 9, 1};
  const int targets[] = {0, 7, 8, 2};
  for (int i = 0; i < 4; ++i) {
    send.add(sources[i]);
    receive.add(targets[i]);
  }
  std::vector<float> from = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  std::vector<float> buffer(4);
  send.pack(from.data(), buffer.data());
  std::vector<float> to(10, -1.0F);
  receive.unpack(to.data(), buffer.data());
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(to[static_cast<std::size_t>(targets[i])], static_cast<float>(sources[i]));
}

}  // namespace
}  // namespace copepod::fluid
