#include "component/command_line.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace copepod::component {
namespace {

const Capabilities kCapabilities{"Test fluid", "1.2", {"collision:trt", "checkpoint"}};

ParsedCommandLine parse(std::vector<std::string> words) {
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  return parse_command_line(static_cast<int>(argv.size()), argv.data(), session::Role::fluid, kCapabilities);
}

TEST(CommandLine, ReadsAddressTokenAndLog) {
  const auto parsed =
      parse({"--endpoint", "ipc:///a", "--session", "t", "--log-file", "f", "--log-level", "debug"});
  ASSERT_TRUE(parsed.options);
  EXPECT_EQ(parsed.options->endpoint, "ipc:///a");
  EXPECT_EQ(parsed.options->session_token, "t");
  EXPECT_EQ(parsed.options->log_file, "f");
  EXPECT_EQ(parsed.options->log_level, "debug");
  EXPECT_EQ(parsed.options->orphan_after_s, 10.0);
}

TEST(CommandLine, RefusesWhatIsMissingOrUnknownWithCode2) {
  EXPECT_EQ(parse({"--endpoint", "ipc:///a"}).exit_code, 2);
  EXPECT_EQ(parse({"--session", "t"}).exit_code, 2);
  EXPECT_EQ(parse({"--bogus"}).exit_code, 2);
  EXPECT_EQ(parse({"--endpoint", "e", "--session", "t", "--log-level", "shout"}).exit_code, 2);
  EXPECT_EQ(parse({"--endpoint", "e", "--session", "t", "--orphan-after", "-1"}).exit_code, 2);
}

TEST(CommandLine, PrintsCapabilitiesAsOneLineOfJson) {
  testing::internal::CaptureStdout();
  const auto parsed = parse({"--capabilities"});
  const std::string output = testing::internal::GetCapturedStdout();
  EXPECT_FALSE(parsed.options);
  EXPECT_EQ(parsed.exit_code, 0);
  EXPECT_EQ(output.find('\n'), output.size() - 1);
  const auto json = nlohmann::json::parse(output);
  EXPECT_EQ(json["name"], "Test fluid");
  EXPECT_EQ(json["version"], "1.2");
  EXPECT_EQ(json["role"], "fluid");
  EXPECT_EQ(json["features"].size(), 2U);
}

}  // namespace
}  // namespace copepod::component
