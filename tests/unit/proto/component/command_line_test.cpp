#include "component/command_line.hpp"

#include <iostream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "contract/errors.hpp"

namespace copepod::component {
namespace {

const Capabilities kCapabilities{"Test fluid", "1.2", {"collision:trt", "checkpoint"}};

ParsedCommandLine parse(std::vector<std::string> words, const EstimateText& estimate = {}) {
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  return parse_command_line(static_cast<int>(argv.size()), argv.data(), session::Role::fluid, kCapabilities, estimate);
}

TEST(CommandLine, ReadsAddressTokenAndLog) {
  const auto parsed = parse({"--endpoint", "ipc:///a", "--session", "t", "--log-file", "f", "--log-level", "debug"});
  ASSERT_TRUE(parsed.options);
  EXPECT_EQ(parsed.options->endpoint, "ipc:///a");
  EXPECT_EQ(parsed.options->session_token, "t");
  EXPECT_EQ(parsed.options->log_file, "f");
  EXPECT_EQ(parsed.options->log_level, "debug");
  EXPECT_EQ(parsed.options->orphan_after_s, 10.0);
}

TEST(CommandLine, RefusesWhatIsMissingOrUnknownWithCode2) {
  EXPECT_EQ(parse({"--endpoint", "ipc:///a"}).answer(), 2);
  EXPECT_EQ(parse({"--session", "t"}).answer(), 2);
  EXPECT_EQ(parse({"--bogus"}).answer(), 2);
  EXPECT_EQ(parse({"--endpoint", "e", "--session", "t", "--log-level", "shout"}).answer(), 2);
  EXPECT_EQ(parse({"--endpoint", "e", "--session", "t", "--orphan-after", "-1"}).answer(), 2);
}

TEST(CommandLine, PrintsCapabilitiesAsOneLineOfJson) {
  testing::internal::CaptureStdout();
  const auto parsed = parse({"--capabilities"});
  EXPECT_FALSE(parsed.options);
  EXPECT_EQ(parsed.answer(), 0);
  const std::string output = testing::internal::GetCapturedStdout();
  EXPECT_EQ(output.find('\n'), output.size() - 1);
  const auto json = nlohmann::json::parse(output);
  EXPECT_EQ(json["name"], "Test fluid");
  EXPECT_EQ(json["version"], "1.2");
  EXPECT_EQ(json["role"], "fluid");
  EXPECT_EQ(json["features"].size(), 2U);
}

TEST(CommandLine, IsAnsweredByTheFirstProcessOfSeveralOnly) {
  setenv("PMIX_RANK", "1", 1);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EXPECT_EQ(parse({"--capabilities"}).answer(), 0);
  EXPECT_EQ(parse({"--help"}).answer(), 0);
  EXPECT_EQ(parse({"--bogus"}).answer(), 0);
  EXPECT_TRUE(parse({"--endpoint", "ipc:///a", "--session", "t"}).options);
  EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
  unsetenv("PMIX_RANK");
}

/// Ends of `--estimate` with this standard input: exit code, standard output and standard error.
struct Estimated {
  int exit_code;
  std::string output, errors;
};

Estimated estimate(const std::string& input, const EstimateText& text, std::vector<std::string> words) {
  std::istringstream source(input);
  std::streambuf* const before = std::cin.rdbuf(source.rdbuf());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  words.insert(words.begin(), "--estimate");
  const auto parsed = parse(words, text);
  EXPECT_FALSE(parsed.options);
  const int exit_code = parsed.answer();
  std::cin.rdbuf(before);
  return {exit_code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

TEST(CommandLine, EstimatesTheSetupOnStandardInput) {
  const EstimateText text = [](const std::string& setup, int ranks) {
    return std::to_string(setup.size()) + " bytes, " + std::to_string(ranks) + " ranks";
  };
  const Estimated estimated = estimate(std::string("a\0b\n", 4), text, {"--ranks", "3"});
  EXPECT_EQ(estimated.exit_code, 0);
  EXPECT_EQ(estimated.output, "4 bytes, 3 ranks\n");
  EXPECT_EQ(estimate("", text, {"--ranks", "0"}).exit_code, 2);
}

TEST(CommandLine, ReportsWhyThereIsNoEstimate) {
  const EstimateText text = [](const std::string&, int) -> std::string { throw CaseError("Too many ranks."); };
  const Estimated refused = estimate("", text, {});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.errors, "error: Too many ranks.\n");
  const Estimated without = estimate("", {}, {});
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_TRUE(without.errors.starts_with("error: this component does not estimate")) << without.errors;
}

}  // namespace
}  // namespace copepod::component
