#include "observers/trajectory_writer.hpp"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

std::vector<std::vector<std::string>> read_csv(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    std::vector<std::string> row;
    std::stringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
    rows.push_back(row);
  }
  return rows;
}

/// Two bodies with numbers that no short decimal represents.
struct Moment {
  Kinematics kinematics;
  Loads raw;
  Loads applied;
  Loads drive;
  explicit Moment(std::int64_t step) {
    kinematics.step = step;
    kinematics.resize(2);
    kinematics.position_m = Eigen::Matrix3Xd::Random(3, 2) / 3.0;
    kinematics.orientation_wxyz = Eigen::Matrix4Xd::Random(4, 2) / 7.0;
    kinematics.velocity_m_per_s = Eigen::Matrix3Xd::Random(3, 2) * 1e-300;
    kinematics.angular_velocity_rad_per_s = Eigen::Matrix3Xd::Random(3, 2) * 1e300;
    raw.resize(2);
    raw.force_N.setZero();
    raw.torque_N_m.setZero();
    applied.resize(2);
    applied.force_N = Eigen::Matrix3Xd::Random(3, 2);
    applied.torque_N_m = Eigen::Matrix3Xd::Random(3, 2);
    drive.force_N = Eigen::Matrix3Xd::Random(3, 2);
  }
  [[nodiscard]] StepRecord record() const { return {kinematics.step, kinematics, raw, applied, drive, raw}; }
};

TEST(TrajectoryWriter, PrintsDoublesThatReadBackBitForBit) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path("bits.csv");
  const Moment moment(0);
  {
    TrajectoryWriter writer(path.string(), {"one", "two"}, 1.0 / 3.0, 1);
    writer.observe(moment.record());
    writer.finish(moment.record());
  }
  const auto rows = read_csv(path);
  ASSERT_EQ(rows.size(), 3U);
  ASSERT_EQ(rows[0].size(), 25U);
  EXPECT_EQ(rows[0][3], "x_m");
  EXPECT_EQ(rows[0][22], "drive_fx_N");
  for (std::size_t body = 0; body < 2; ++body) {
    std::vector<double> expected;
    const auto column = static_cast<Eigen::Index>(body);
    const auto push = [&](const auto& matrix) {
      for (Eigen::Index i = 0; i < matrix.rows(); ++i) expected.push_back(matrix(i, column));
    };
    push(moment.kinematics.position_m);
    push(moment.kinematics.orientation_wxyz);
    push(moment.kinematics.velocity_m_per_s);
    push(moment.kinematics.angular_velocity_rad_per_s);
    push(moment.applied.force_N);
    push(moment.applied.torque_N_m);
    push(moment.drive.force_N);
    const auto& row = rows[1 + body];
    ASSERT_EQ(row.size(), 25U);
    EXPECT_EQ(row[2], body == 0 ? "one" : "two");
    for (std::size_t i = 0; i < expected.size(); ++i) {
      double value = 0.0;
      std::from_chars(row[3 + i].data(), row[3 + i].data() + row[3 + i].size(), value);
      EXPECT_EQ(value, expected[i]) << rows[0][3 + i];
    }
  }
}

TEST(TrajectoryWriter, SamplesTheFirstTheLastAndEveryNthStepOnce) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path("sampling.csv");
  {
    TrajectoryWriter writer(path.string(), {"one", "two"}, 0.5, 4);
    for (std::int64_t step = 0; step < 10; ++step) writer.observe(Moment(step).record());
    writer.finish(Moment(10).record());
  }
  std::vector<std::string> steps;
  for (const auto& row : read_csv(path)) {
    if (row[2] == "one") steps.push_back(row[0] + "@" + row[1]);
  }
  EXPECT_EQ(steps, (std::vector<std::string>{"0@0", "4@2", "8@4", "10@5"}));
}

TEST(TrajectoryWriter, LeavesOutWhatLiesBetweenTheFirstStepAndTheBeginningOfSampling) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path("window.csv");
  {
    TrajectoryWriter writer(path.string(), {"one", "two"}, 0.5, 2, 5);
    for (std::int64_t step = 0; step < 10; ++step) writer.observe(Moment(step).record());
    writer.finish(Moment(10).record());
  }
  std::vector<std::string> steps;
  for (const auto& row : read_csv(path)) {
    if (row[2] == "one") steps.push_back(row[0]);
  }
  EXPECT_EQ(steps, (std::vector<std::string>{"0", "6", "8", "10"}));
}

TEST(TrajectoryWriter, WritesFirstAndLastStepOnlyForIntervalZero) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path("ends.csv");
  {
    TrajectoryWriter writer(path.string(), {"one", "two"}, 0.5, 0);
    for (std::int64_t step = 0; step < 10; ++step) writer.observe(Moment(step).record());
    writer.finish(Moment(10).record());
  }
  EXPECT_EQ(read_csv(path).size(), 5U);
}

TEST(TrajectoryWriter, LeavesWholeLinesWhenTheRunFails) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path("whole.csv");
  {
    TrajectoryWriter writer(path.string(), {"one", "two"}, 0.5, 1);
    for (std::int64_t step = 0; step < 5; ++step) writer.observe(Moment(step).record());
  }
  const auto rows = read_csv(path);
  EXPECT_EQ(rows.size(), 11U);
  EXPECT_EQ(rows.back().size(), 25U);
}

TEST(TrajectoryWriter, QuotesNamesThatWouldBreakTheTable) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path("names.csv");
  {
    TrajectoryWriter writer(path.string(), {"a,b", "call \"hi\""}, 0.5, 1);
    writer.finish(Moment(0).record());
  }
  const std::string text = content_of(path);
  EXPECT_NE(text.find(",\"a,b\","), std::string::npos);
  EXPECT_NE(text.find(",\"call \"\"hi\"\"\","), std::string::npos);
}

TEST(TrajectoryWriter, SaysWhyAFileCannotBeWritten) {
  EXPECT_THROW(TrajectoryWriter("/nonexistent/folder/t.csv", {"a"}, 1.0, 1), StorageError);
}

TEST(TrajectoryWriter, SaysThatTheDiskIsFull) {
  EXPECT_THROW(TrajectoryWriter("/dev/full", {"a"}, 1.0, 1), StorageError);
}

}  // namespace
}  // namespace copepod::coupler
