#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/load_case.hpp"
#include "config/yaml/document.hpp"

namespace copepod::coupler {
namespace {

/// Splits at a separator and trims.
std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) {
    part.erase(0, part.find_first_not_of(' '));
    part.erase(part.find_last_not_of(' ') + 1);
    parts.push_back(part);
  }
  return parts;
}

/// Errors announced in a case file: a comment `# error: words | more words & other error` in the line they
/// belong to.
std::multimap<int, std::vector<std::string>> announced_errors(const std::filesystem::path& file) {
  std::multimap<int, std::vector<std::string>> expected;
  std::ifstream stream(file);
  int line_number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++line_number;
    const std::string mark = "# error: ";
    const std::size_t place = line.find(mark);
    if (place == std::string::npos) continue;
    for (const std::string& error : split(line.substr(place + mark.size()), '&'))
      expected.emplace(line_number, split(error, '|'));
  }
  return expected;
}

std::vector<std::string> errors_of(const std::filesystem::path& file) {
  try {
    load_case(file.string(), {});
  } catch (const CaseInvalid& invalid) {
    return invalid.lines();
  }
  return {};
}

std::vector<std::string> broken_cases() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(BROKEN_CASES))
    names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

class BrokenCase : public testing::TestWithParam<std::string> {};

TEST_P(BrokenCase, IsRejectedWithFileAndLineReasonAndRemedy) {
  const std::filesystem::path file = std::filesystem::path(BROKEN_CASES) / (GetParam() + ".yaml");
  std::vector<std::string> found = errors_of(file);
  for (const auto& [line, words] : announced_errors(file)) {
    const std::string place = file.string() + ":" + std::to_string(line) + ": error: ";
    const auto match = std::find_if(found.begin(), found.end(), [&, &expected = words](const std::string& error) {
      return error.starts_with(place) && std::all_of(expected.begin(), expected.end(), [&](const std::string& word) {
               return error.find(word) != std::string::npos;
             });
    });
    EXPECT_NE(match, found.end()) << "expected at line " << line << ": " << words.front() << "\nfound:\n"
                                  << testing::PrintToString(found);
    if (match == found.end()) continue;
    // "problem (why). What to do."
    EXPECT_NE(match->find(" ("), std::string::npos) << *match;
    EXPECT_NE(match->find("). "), std::string::npos) << *match;
    found.erase(match);
  }
  EXPECT_TRUE(found.empty()) << "unannounced errors: " << testing::PrintToString(found);
}

INSTANTIATE_TEST_SUITE_P(Config, BrokenCase, testing::ValuesIn(broken_cases()),
                         [](const auto& instance) { return instance.param; });

TEST(BrokenCases, AreAtLeastTwentyFiveDifferentOnes) { EXPECT_GE(broken_cases().size(), 25U); }

}  // namespace
}  // namespace copepod::coupler
