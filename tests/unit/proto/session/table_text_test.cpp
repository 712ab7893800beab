#include "session/table_text.hpp"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "session/transition_table.hpp"

namespace copepod::session {
namespace {

TEST(TableText, IsWhatTheDocumentationShows) {
  std::ostringstream page;
  page << std::ifstream(PROTOCOL_PAGE).rdbuf();
  const std::string begin = "<!-- protocol_table --markdown -->\n";
  const std::size_t from = page.str().find(begin);
  const std::size_t to = page.str().find("<!-- end -->");
  ASSERT_NE(from, std::string::npos);
  EXPECT_EQ(page.str().substr(from + begin.size(), to - from - begin.size()), table_as_markdown())
      << "put the output of `protocol_table --markdown` between the two marks of docs/protocol.md";
}

TEST(TableText, HoldsEveryRowAsJson) {
  const auto rows = nlohmann::json::parse(table_as_json());
  ASSERT_EQ(rows.size(), kTransitions.size());
  EXPECT_EQ(rows[2]["roles"], nlohmann::json({"fluid"}));
  EXPECT_EQ(rows[2]["from"], nlohmann::json({"greeted"}));
  EXPECT_EQ(rows[2]["message"], "FluidSetup");
  EXPECT_EQ(rows[2]["to"], "configured");
  EXPECT_EQ(rows[2]["reply"], "Configured");
}

}  // namespace
}  // namespace copepod::session
