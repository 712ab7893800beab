#include "storage/csv_file.hpp"

#include <filesystem>
#include <fstream>
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

}  // namespace
}  // namespace copepod::coupler
