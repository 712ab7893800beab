#include <gtest/gtest.h>

#include "config/yaml/keys.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

class CsvRowsOfAFile : public testing::Test {
 protected:
  /// Of the file «places.csv» beside a case that names it.
  std::optional<CsvRows> read(const std::string& content) {
    std::ofstream(folder_.path("places.csv")) << content;
    std::ofstream(folder_.path("case.yaml")) << "file: places.csv\n";
    const Document document = Document::load(folder_.path("case.yaml"), {});
    Problems problems(document);
    Keys keys(&document.root(), "", problems);
    std::optional<CsvRows> rows = read_csv_rows(keys, "file", {"x", "y"}, {"u", "v"});
    problem_.clear();
    try {
      problems.throw_if_any();
    } catch (const CaseInvalid& invalid) {
      EXPECT_EQ(invalid.lines().size(), 1U);
      problem_ = invalid.lines()[0].substr(folder_.path().string().size() + 1);
    }
    return rows;
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  TemporaryFolder folder_;
  std::string problem_;
};

TEST_F(CsvRowsOfAFile, HaveTheirColumnsInAnyOrder) {
  const auto rows = read("# by hand\ny, x\r\n\n1.5, -2e-3\r\n 3 ,4\n");
  ASSERT_TRUE(rows) << problem();
  EXPECT_EQ(rows->values, (std::vector<std::vector<double>>{{-2e-3, 1.5}, {4, 3}}));
  EXPECT_EQ(rows->lines, (std::vector<int>{4, 5}));
  EXPECT_FALSE(rows->has_optional);
}

TEST_F(CsvRowsOfAFile, MayHaveTheOptionalColumns) {
  const auto rows = read("v,x,y,u\n4,1,2,3\n");
  ASSERT_TRUE(rows) << problem();
  EXPECT_TRUE(rows->has_optional);
  EXPECT_EQ(rows->values, (std::vector<std::vector<double>>{{1, 2, 3, 4}}));
}

TEST_F(CsvRowsOfAFile, ReportWhatCannotBeUsedWithItsLine) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"x,y,z\n1,2,3\n", "places.csv:1: error: column 'z' is unknown"},
      {"x,y,u\n1,2,3\n", "places.csv:1: error: column 'v' is missing"},
      {"x\n1\n", "places.csv:1: error: column 'y' is missing"},
      {"x,y,x\n1,2,3\n", "places.csv:1: error: column 'x' is there twice"},
      {"x,y\n1,2\n1,2,3\n", "places.csv:3: error: the row has 3 entries"},
      {"x,y\n1,two\n", "places.csv:2: error: 'two' is not a finite number"},
      {"x,y\n1,inf\n", "places.csv:2: error: 'inf' is not a finite number"},
      {"x,y\n", "case.yaml:1: error: file has no rows"},
      {"", "case.yaml:1: error: file has no rows"}};
  for (const auto& [content, expected] : cases) {
    EXPECT_FALSE(read(content)) << content;
    EXPECT_TRUE(problem().starts_with(expected)) << problem();
  }
}

TEST(CsvRows, OfAFileThatIsNotThere) {
  const Document document = Document::parse("file: nowhere.csv\n", "case.yaml", {});
  Problems problems(document);
  Keys keys(&document.root(), "", problems);
  EXPECT_FALSE(read_csv_rows(keys, "file", {"x"}, {}));
  EXPECT_TRUE(problems.any_under("file"));
}

}  // namespace
}  // namespace copepod::coupler
