#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "observers/events.hpp"

namespace copepod::coupler {
namespace {

TEST(Progress, ReportsFirstAndLastStepAndNotEveryOneBetween) {
  std::ostringstream stream;
  Events events(stream);
  Progress progress(events, 1000);
  const Kinematics kinematics;
  const Loads loads;
  for (std::int64_t step = 0; step < 1000; ++step) progress.observe({step, kinematics, loads, loads, loads, loads});
  progress.finish({1000, kinematics, loads, loads, loads, loads});
  std::vector<nlohmann::json> lines;
  std::istringstream text(stream.str());
  for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
  ASSERT_GE(lines.size(), 2U);
  EXPECT_LT(lines.size(), 100U);
  EXPECT_EQ(lines.front()["step"], 0);
  EXPECT_EQ(lines.front()["remaining_s"], 0.0);
  EXPECT_EQ(lines.back()["step"], 1000);
  EXPECT_EQ(lines.back()["steps"], 1000);
  EXPECT_GT(lines.back()["steps_per_s"].get<double>(), 0.0);
  EXPECT_EQ(lines.back()["remaining_s"], 0.0);
}

}  // namespace
}  // namespace copepod::coupler
