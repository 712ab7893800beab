#include <algorithm>
#include <fstream>
#include <map>
#include <ostream>
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

/// A case that must be rejected.
struct Broken {
  std::string name;
  int first_line = 1;  ///< of its text in BROKEN_CASES
  std::string text;

  friend void PrintTo(const Broken& broken, std::ostream* stream) { *stream << broken.name; }
};

/// The documents of BROKEN_CASES, and one that a file of UTF-8 cannot hold.
std::vector<Broken> broken_cases() {
  std::vector<Broken> cases;
  std::ifstream stream(BROKEN_CASES);
  const std::string separator = "--- # ";
  int line_number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++line_number;
    if (line.starts_with(separator))
      cases.push_back({line.substr(separator.size()), line_number + 1, {}});
    else if (!cases.empty())
      cases.back().text += line + '\n';
  }
  cases.push_back({"name_in_latin_1", 1,
                   "case: broken\nfluid: {solver: vacuum}\nstep_s: 1.0e-9\nbodies:\n"
                   "  - {name: K\xfcgelchen, radius_m: 4.0e-6, mass_kg: 5.0e-13, position_m: [0, 0, 0]}"
                   "  # error: not UTF-8 text\nrun: {steps: 100}\n"});
  return cases;
}

/// Errors that a case announces, by their line: a comment `# error: words | more words & other error`.
std::multimap<int, std::vector<std::string>> announced_errors(const Broken& broken) {
  std::multimap<int, std::vector<std::string>> expected;
  std::istringstream stream(broken.text);
  int line_number = broken.first_line - 1;
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

/// Empty lines in front give every message the line in BROKEN_CASES.
std::vector<std::string> errors_of(const Broken& broken) {
  try {
    load_case_text(std::string(static_cast<std::size_t>(broken.first_line - 1), '\n') + broken.text, BROKEN_CASES, {});
  } catch (const CaseInvalid& invalid) {
    return invalid.lines();
  }
  return {};
}

class BrokenCase : public testing::TestWithParam<Broken> {};

TEST_P(BrokenCase, IsRejectedWithFileAndLineReasonAndRemedy) {
  std::vector<std::string> found = errors_of(GetParam());
  ASSERT_FALSE(found.empty()) << "accepted";
  for (const auto& [line, words] : announced_errors(GetParam())) {
    const std::string place = std::string(BROKEN_CASES) + ":" + std::to_string(line) + ": error: ";
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
                         [](const auto& instance) { return instance.param.name; });

TEST(BrokenCases, AreAtLeastTwentyFiveDifferentOnes) { EXPECT_GE(broken_cases().size(), 25U); }

}  // namespace
}  // namespace copepod::coupler
