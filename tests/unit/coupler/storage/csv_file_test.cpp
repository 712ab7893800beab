#include "storage/csv_file.hpp"

#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

class Table : public testing::Test {
 protected:
  [[nodiscard]] std::string content() const {
    std::ifstream stream(path);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }
  void write(const std::string& text) const { std::ofstream(path) << text; }

  TemporaryFolder folder;
  std::string path = folder.path("table.csv");
};

bool is_small(std::string_view row) { return row < "5"; }

TEST_F(Table, HoldsItsHeaderAtOnceAndItsRowsWhenFlushed) {
  CsvFile file(path, "a,b", {});
  EXPECT_EQ(content(), "a,b\n");
  file.add("1,2");
  file.add("3,4");
  EXPECT_EQ(content(), "a,b\n");
  file.flush();
  EXPECT_EQ(content(), "a,b\n1,2\n3,4\n");
}

TEST_F(Table, ReplacesAnExistingOneUnlessRowsAreKept) {
  write("a,b\n1,2\n");
  { const CsvFile file(path, "a,b", {}); }
  EXPECT_EQ(content(), "a,b\n");
}

TEST_F(Table, KeepsRowsUpToTheFirstThatMustGo) {
  write("a,b\n1,2\n3,4\n7,8\n2,2\n");
  {
    CsvFile file(path, "a,b", is_small);
    file.add("9,9");
  }
  EXPECT_EQ(content(), "a,b\n1,2\n3,4\n9,9\n");
}

TEST_F(Table, KeepsNoRowThatWasCutOffAndNoTableOfAnotherHeader) {
  write("a,b\n1,2\n3,4");
  { const CsvFile file(path, "a,b", is_small); }
  EXPECT_EQ(content(), "a,b\n1,2\n");
  { const CsvFile file(path, "a,b,c", is_small); }
  EXPECT_EQ(content(), "a,b,c\n");
}

TEST_F(Table, CannotBeWrittenWhereThereIsNoFolder) {
  EXPECT_THROW(CsvFile(folder.path("no/table.csv"), "a", {}), StorageError);
}

TEST(CsvField, QuotesNamesThatNeedIt) {
  EXPECT_EQ(csv_field("plain name"), "plain name");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a \"b\""), "\"a \"\"b\"\"\"");
}

}  // namespace
}  // namespace copepod::coupler
