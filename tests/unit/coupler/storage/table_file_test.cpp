#include "storage/table_file.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "limited_file_size.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

class Table : public testing::Test {
 protected:
  [[nodiscard]] std::string content() const { return content_of(path); }
  void write(const std::string& text) const { std::ofstream(path) << text; }

  TemporaryFolder folder;
  std::string path = folder.path("table.csv");
};

TEST_F(Table, HoldsItsHeaderAtOnceAndItsRowsWhenFlushed) {
  CsvFile file(path, "a,b", {});
  EXPECT_EQ(content(), "a,b\n");
  file.add("1,2");
  file.add("3,4");
  EXPECT_EQ(content(), "a,b\n");
  file.flush();
  EXPECT_EQ(content(), "a,b\n1,2\n3,4\n");
}

TEST_F(Table, ReplacesAnExistingOneUnlessItIsContinued) {
  write("a,b\n1,2\n");
  { const CsvFile file(path, "a,b", {}); }
  EXPECT_EQ(content(), "a,b\n");
}

TEST_F(Table, IsContinuedFromAnEndThatItHad) {
  TableEnd end;
  {
    CsvFile file(path, "a,b", {});
    file.add("1,2");
    file.add("3,4");
    end = file.sync();
    file.add("7,8");
  }
  for (int attempt = 0; attempt < 2; ++attempt) {
    EXPECT_EQ(find_damage(path, end), "");
    CsvFile file(path, "a,b", end);
    file.add("9,9");
    end = file.sync();
    file.add("5,5");
  }
  EXPECT_EQ(content(), "a,b\n1,2\n3,4\n9,9\n9,9\n5,5\n");
}

TEST_F(Table, IsNotContinuedWhereItIsNotWhatItWas) {
  TableEnd end;
  {
    CsvFile file(path, "a,b", {});
    file.add("1,2");
    end = file.sync();
  }
  EXPECT_THROW(CsvFile(path, "a,c", end), StorageError);  // it has other columns
  for (const char* changed : {"", "a,b\n1,", "a,b\n1,3\n7,8\n", "a,c\n1,2\n"}) {
    write(changed);
    EXPECT_NE(find_damage(path, end), "") << changed;
    EXPECT_THROW(CsvFile(path, "a,b", end), StorageError) << changed;
    EXPECT_EQ(content(), changed);
  }
  std::filesystem::remove(path);
  EXPECT_NE(find_damage(path, end).find("lacks rows"), std::string::npos);
  EXPECT_THROW(CsvFile(path, "a,b", end), StorageError);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(Table, CannotBeWrittenWhereThereIsNoFolder) {
  EXPECT_THROW(CsvFile(folder.path("no/table.csv"), "a", {}), StorageError);
}

TEST_F(Table, NamesALimitOfItsSize) {
  CsvFile file(path, "a", {});
  const LimitedFileSize limit(4);
  file.add("a long row");
  try {
    file.flush();
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("ulimit -f"), std::string::npos) << error.what();
  }
}

TEST(CsvField, QuotesNamesThatNeedIt) {
  EXPECT_EQ(csv_field("plain name"), "plain name");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a \"b\""), "\"a \"\"b\"\"\"");
}

constexpr std::uint64_t sample_bytes = 8 + 6 * 8;

/// Samples [start, stop) behind `end`, synced after `synced` of them. @return where the table ended then
TableEnd write_samples(const std::string& path, std::int64_t start, std::int64_t synced, std::int64_t stop,
                       const std::optional<TableEnd>& end, const std::string& rows = "2") {
  NpyFile file(path, "[('step', '<i8'), ('position_m', '<f8', (" + rows + ", 3))]", sample_bytes, end);
  TableEnd result;
  for (std::int64_t step = start; step < stop; ++step) {
    if (step == synced) result = file.sync();
    std::array<double, 6> position_m{};
    position_m.fill(static_cast<double>(step) / 3.0);
    file.add(std::array{std::as_bytes(std::span(&step, 1)), std::as_bytes(std::span<const double>(position_m))});
  }
  return result;
}

// That NumPy reads these files is tested in tests/integration/trajectory_test.py.

TEST(Samples, HaveTheSameBytesWhetherTheRunWasInterruptedOrNot) {
  const TemporaryFolder folder;
  const std::string whole = folder.path("whole.npy"), resumed = folder.path("resumed.npy");
  write_samples(whole, 0, 0, 200, {});
  EXPECT_EQ(content_of(whole).size(), NpyFile::head_bytes + 200 * sample_bytes);
  for (const std::int64_t cut : {0L, 1L, 99L, 150L}) {
    std::filesystem::remove(resumed);
    const TableEnd end = write_samples(resumed, 0, cut, 180, {});
    write_samples(resumed, cut, 0, 200, end);
    EXPECT_TRUE(content_of(resumed) == content_of(whole)) << cut;
  }
}

TEST(Samples, AreAnnouncedOnceTheyAreThere) {
  const TemporaryFolder folder;
  const std::string path = folder.path("table.npy");
  NpyFile file(path, "[('step', '<i8')]", 8, {});
  const std::int64_t step = 7;
  file.add(std::array{std::as_bytes(std::span(&step, 1))});
  EXPECT_NE(content_of(path).find("'shape': (0,)"), std::string::npos);
  EXPECT_EQ(content_of(path).size(), NpyFile::head_bytes);
  file.flush();
  EXPECT_NE(content_of(path).find("'shape': (1,)"), std::string::npos);
  EXPECT_EQ(content_of(path).size(), NpyFile::head_bytes + 8);
}

TEST(Samples, AreNotContinuedWithoutThoseThatTheFileHad) {
  const TemporaryFolder folder;
  const std::string path = folder.path("table.npy");
  const TableEnd end = write_samples(path, 0, 150, 200, {});
  EXPECT_EQ(find_damage(path, end), "");
  EXPECT_EQ(end.bytes, 150 * sample_bytes);
  const std::string kept = content_of(path);
  const auto changed_at = [&](std::size_t place) {
    std::string content = kept;
    content[place] ^= 1;
    std::ofstream(path, std::ios::binary) << content;
    return find_damage(path, end);
  };
  EXPECT_EQ(changed_at(NpyFile::head_bytes + end.bytes), "") << "samples behind the checkpoint do not matter";
  EXPECT_EQ(changed_at(NpyFile::head_bytes + end.bytes - 1), path + " has changed");
  EXPECT_THROW(write_samples(path, 150, 0, 151, end), StorageError);
  EXPECT_EQ(changed_at(NpyFile::head_bytes - 1), "");
  const std::string before = content_of(path);
  EXPECT_THROW(write_samples(path, 150, 0, 151, end, "3"), StorageError) << "of other bodies";
  EXPECT_EQ(content_of(path).substr(0, NpyFile::head_bytes), before.substr(0, NpyFile::head_bytes));
  for (const std::string& left : {kept.substr(0, kept.size() / 2), std::string("step,body\n"), std::string()}) {
    std::ofstream(path, std::ios::binary) << left;
    EXPECT_EQ(find_damage(path, end), path + " lacks rows that it had");
  }
  std::filesystem::remove(path);
  EXPECT_EQ(find_damage(path, end), path + " lacks rows that it had");
}

TEST(Samples, NameAFullDisk) {
  EXPECT_THROW(write_samples("/dev/full", 0, 0, 1, {}), StorageError);
  EXPECT_THROW(write_samples("/nonexistent/folder/t.npy", 0, 0, 1, {}), StorageError);
}

}  // namespace
}  // namespace copepod::coupler
