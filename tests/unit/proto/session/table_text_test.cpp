#include "session/table_text.hpp"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "session/table_diagram.hpp"
#include "session/transition_table.hpp"

namespace copepod::session {
namespace {

/// What docs/protocol.md shows as output of `protocol_table` with this option.
std::string shown_as(const std::string& option) {
  std::ostringstream page;
  page << std::ifstream(PROTOCOL_PAGE).rdbuf();
  const std::string begin = "<!-- protocol_table " + option + " -->\n";
  const std::size_t from = page.str().find(begin);
  if (from == std::string::npos) return "docs/protocol.md has no mark " + begin;
  const std::size_t to = page.str().find("<!-- end -->", from);
  return page.str().substr(from + begin.size(), to - from - begin.size());
}

TEST(TableText, IsWhatTheDocumentationShows) {
  EXPECT_EQ(shown_as("--markdown"), table_as_markdown())
      << "put the output of `protocol_table --markdown` between the two marks of docs/protocol.md";
}

TEST(FeatureTable, IsWhatTheDocumentationShows) {
  EXPECT_EQ(shown_as("--features"), features_as_markdown())
      << "put the output of `protocol_table --features` between the two marks of docs/protocol.md";
}

TEST(TableDiagram, IsWhatTheDocumentationShows) {
  EXPECT_EQ(shown_as("--mermaid"), table_as_mermaid())
      << "put the output of `protocol_table --mermaid` between the two marks of docs/protocol.md";
}

TEST(TableDiagram, LeadsFromTheStartToEachEnd) {
  const std::string diagram = table_as_mermaid();
  for (const char* arrow :
       {"[*] --> connected: Hello", "connected --> failed: Refusal", "ready --> done: Finish → Finished",
        "stepping --> ready: work done", "running --> orphaned: coupler lost"}) {
    EXPECT_NE(diagram.find(arrow), std::string::npos) << arrow << " is missing in\n" << diagram;
  }
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
