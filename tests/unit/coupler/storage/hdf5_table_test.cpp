#include "storage/hdf5_table.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "temporary_folder.hpp"

// That HDF5 reads these files is tested in tests/integration/trajectory_test.py.

namespace copepod::coupler {
namespace {

constexpr std::uint64_t rows = 2;

/// Samples [start, stop) behind `end`, synced after `synced` of them. @return where the table ended then
TableEnd write_samples(const std::string& path, std::int64_t start, std::int64_t synced, std::int64_t stop,
                       const std::optional<TableEnd>& end) {
  Hdf5Table table(path, {{"step", Hdf5Column::Kind::whole_number}, {"position_m", Hdf5Column::Kind::real, 3}}, "body",
                  {"a", "long name"}, end);
  TableEnd result;
  for (std::int64_t step = start; step < stop; ++step) {
    if (step == synced) result = table.sync();
    std::array<double, 3 * rows> position_m{};
    for (std::size_t i = 0; i < position_m.size(); ++i)
      position_m[i] = static_cast<double>(step) / 3.0 + static_cast<double>(i);
    table.add(std::array{std::as_bytes(std::span(&step, 1)), std::as_bytes(std::span<const double>(position_m))});
  }
  return result;
}

TEST(Hdf5Table, HasTheSameBytesWhetherTheRunWasInterruptedOrNot) {
  const TemporaryFolder folder;
  constexpr std::int64_t samples = 64 * 64 + 200;  // two blocks of 64 groups of 64 samples
  const std::string whole = folder.path("whole.h5"), resumed = folder.path("resumed.h5");
  write_samples(whole, 0, 0, samples, {});
  for (const std::int64_t cut : {0L, 1L, 63L, 64L, 4095L, 4096L, 4097L}) {
    std::filesystem::remove(resumed);
    const TableEnd end = write_samples(resumed, 0, cut, samples - 50, {});
    write_samples(resumed, cut, 0, samples, end);
    EXPECT_TRUE(content_of(resumed) == content_of(whole)) << cut;
  }
}

TEST(Hdf5Table, IsNotContinuedWithoutTheSamplesThatItHad) {
  const TemporaryFolder folder;
  const std::string path = folder.path("table.h5");
  const TableEnd end = write_samples(path, 0, 150, 200, {});
  EXPECT_EQ(find_damage(path, end), "");
  EXPECT_EQ(end.bytes, 150 * (8 + 3 * rows * 8));
  std::string content = content_of(path);
  const std::string kept = content;
  content[content.size() - 64 * 3 * rows * 8 - 100] ^= 1;  // in a step behind `end`
  std::ofstream(path, std::ios::binary) << content;
  EXPECT_EQ(find_damage(path, end), "") << "samples behind the checkpoint do not matter";
  content[content.size() - 3 * 64 * (8 + 3 * rows * 8)] ^= 1;
  std::ofstream(path, std::ios::binary) << content;
  EXPECT_EQ(find_damage(path, end), path + " has changed");
  EXPECT_THROW(write_samples(path, 150, 0, 151, end), StorageError);
  std::ofstream(path, std::ios::binary) << kept.substr(0, kept.size() / 2);
  EXPECT_EQ(find_damage(path, end), path + " lacks rows that it had");
  std::ofstream(path, std::ios::binary) << "step,body\n";
  EXPECT_EQ(find_damage(path, end), path + " lacks rows that it had");
  std::filesystem::remove(path);
  EXPECT_EQ(find_damage(path, end), path + " lacks rows that it had");
}

TEST(Hdf5Table, PlacesNothingTwice) {
  Hdf5Layout layout{{8, 48}, 3, 5000, 4200};
  std::uint64_t end = layout.first_block;
  for (std::uint64_t group = 0; group < 64 * 64 * 2 + 1; ++group) {
    std::uint64_t span = Hdf5Layout::fan_out;
    for (std::uint64_t level = 0; level < Hdf5Layout::levels && group % span == 0;
         ++level, span *= Hdf5Layout::fan_out) {
      ASSERT_EQ(layout.nodes_at(level, group), end) << group;
      end += layout.node_bytes;
    }
    ASSERT_EQ(layout.group_at(group), end) << group;
    end += layout.group_bytes();
  }
}

TEST(Hdf5Table, SaysThatTheDiskIsFull) {
  EXPECT_THROW(write_samples("/dev/full", 0, 0, 1, {}), StorageError);
  EXPECT_THROW(write_samples("/nonexistent/folder/t.h5", 0, 0, 1, {}), StorageError);
}

}  // namespace
}  // namespace copepod::coupler
