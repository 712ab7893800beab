#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "config/load_case.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

/// Two balls with a spring, in vacuum, steps of 1 ms, and an actuator.
LoadedCase with(const std::string& actuator) {
  return load_case_text(
      "case: two\nfluid: {solver: vacuum}\nstep_s: 0.001\nbodies:\n"
      "  - {name: a, radius_m: 1, mass_kg: 1, position_m: [0, 0, 0]}\n"
      "  - {name: b, radius_m: 1, mass_kg: 1, position_m: [0, 0, 4]}\n"
      "springs: [{bodies: [a, b], stiffness_N_per_m: 7, rest_length_m: 4, "
      "anchors_m: [[0, 0, 0.5], [0, 0, 0]]}]\n"
      "actuators: [" +
          actuator + "]\nrun: {steps: 400}\n",
      "two.yaml", {});
}

Signal signal_of(const std::string& signal) {
  return with("{kind: world_force, body: a, direction: [0, 0, 1], signal: {amplitude_N: 2, " + signal + "}}")
      .assembly.drive[0]
      .signal;
}

TEST(SignalSection, TakesTimesInStepsSecondsAndAngles) {
  EXPECT_EQ(signal_of("kind: sinusoid, period_steps: 400, lag_steps: 12.5").lag_steps, 12.5);
  EXPECT_EQ(signal_of("kind: sinusoid, period_steps: 400, lag_s: 0.1").lag_steps, 0.1 / 0.001);
  EXPECT_EQ(signal_of("kind: sinusoid, period_steps: 400, lag_deg: 90").lag_steps, 100);
  EXPECT_DOUBLE_EQ(signal_of("kind: sinusoid, period_steps: 400, lag_rad: 1.5707963267948966").lag_steps, 100);
  EXPECT_EQ(signal_of("kind: square, period_s: 0.4").period_steps, 400);
}

TEST(SignalSection, WarnsOfAPeriodThatIsRounded) {
  const LoadedCase loaded = with(
      "{kind: body_torque, body: a, direction: [0, 0, 1], signal: {kind: sinusoid, amplitude_N_m: 1, "
      "period_s: 0.1004}}");
  EXPECT_EQ(loaded.assembly.drive[0].signal.period_steps, 100);
  ASSERT_EQ(loaded.warnings.size(), 1U);
  EXPECT_NE(loaded.warnings[0].find("100.4 steps"), std::string::npos) << loaded.warnings[0];
}

TEST(ActuatorSection, TurnsARestLengthIntoAPairForceAlongItsSpring) {
  const LoadedCase loaded = with("{kind: rest_length, bodies: [b, a], signal: {kind: constant, amplitude_m: 0.5}}");
  const auto& [actuator, signal] = loaded.assembly.drive[0];
  EXPECT_EQ(actuator.kind, ActuatorKind::pair_force);
  EXPECT_EQ(actuator.body_A, 0);
  EXPECT_EQ(actuator.body_B, 1);
  EXPECT_EQ(actuator.anchor_A_m, Eigen::Vector3d(0, 0, 0.5));
  EXPECT_EQ(value_of(signal, 0, 0.0), 3.5);
}

class TableFile : public testing::Test {
 protected:
  /// The signal of a case beside a file table.csv of the given content.
  LoadedCase load(const std::string& content) {
    std::ofstream(folder_.path("table.csv")) << content;
    std::ofstream(folder_.path("case.yaml"))
        << "case: table\nfluid: {solver: vacuum}\nstep_s: 0.001\n"
           "bodies: [{name: a, radius_m: 1, mass_kg: 1, position_m: [0, 0, 0]}]\n"
           "actuators: [{kind: world_force, body: a, direction: [0, 0, 1], signal: {kind: table, file: table.csv}}]\n"
           "run: {steps: 10}\n";
    return load_case(folder_.path("case.yaml"), {});
  }

  /// The error of that case.
  std::string error_of(const std::string& content) {
    try {
      load(content);
    } catch (const CaseInvalid& invalid) {
      return invalid.what();
    }
    return "no error";
  }

  TemporaryFolder folder_;
};

TEST_F(TableFile, IsReadBesideTheCaseAndKeptInTheResolvedCase) {
  const LoadedCase loaded = load("time_s,value\n0.0,1\n\n0.004, 3\r\n0.01,-1\n");
  const Signal& signal = loaded.assembly.drive[0].signal;
  ASSERT_EQ(signal.table.size(), 3U);
  EXPECT_EQ(value_of(signal, 2, 0.0), 2.0);
  EXPECT_EQ(value_of(signal, 10, 0.0), -1.0);
  std::filesystem::remove(folder_.path("table.csv"));
  const LoadedCase again = load_case_text(to_yaml(resolved(loaded.content)), "elsewhere.yaml", {});
  for (std::int64_t step = 0; step < 12; ++step)
    EXPECT_EQ(value_of(again.assembly.drive[0].signal, step, 0.5), value_of(signal, step, 0.5)) << step;
}

TEST_F(TableFile, HasTheSameRowsHoweverASpreadsheetWritesThem) {
  const std::vector<Signal::Point> plain = load("0.0,0.25\n0.004,-1\n").assembly.drive[0].signal.table;
  for (const std::string content :
       {"time_s,value\n0.0,0.25\n0.004,-1\n", "value,time_s\n0.25,0\n-1,0.004\n", "seconds,newtons\n0,0.25\n0.004,-1\n",
        "\"0.0\",\"0.25\"\n0.004,-1\n", "\"time_s\",\"value\"\r\n\"0.0\",\"0.25\"\r\n\"0.004\",\"-1\"\r\n",
        "\xEF\xBB\xBF"
        "0.0,0.25\n0.004,-1\n",
        "\xEF\xBB\xBF\"time_s\",value\n0.0,0.25\n0.004,-1\n", "+0.0e+00,+2.5e-01\n+4.0e-03,-1\n",
        "0.0;0.25\n0.004;-1\n", "time_s\tvalue\n0.0\t0.25\n0.004\t-1\n"}) {
    const std::vector<Signal::Point> read = load(content).assembly.drive[0].signal.table;
    ASSERT_EQ(read.size(), plain.size()) << content;
    for (std::size_t row = 0; row < plain.size(); ++row) {
      EXPECT_EQ(read[row].time_steps, plain[row].time_steps) << content;
      EXPECT_EQ(read[row].value, plain[row].value) << content;
    }
  }
}

TEST_F(TableFile, IsReportedWithItsLine) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"time_s,value\n0,1\n0.1;2\n", "table.csv:3: error: the row has 1 entries (there are 2 columns)"},
      {"0,1\n0,2\n", "table.csv:2: error: time 0 s does not follow"},
      {"time_s,value\n", "has no rows"},
      {"0;1\n1;2,5\n", "table.csv:2: error: '2,5' is not a finite number (the decimal sign is a point)"},
      {"0,1\n1,\xC2\xA0"
       "2\n",
       R"(table.csv:2: error: '\xC2\xA02' is not a finite number)"},
      {"0,1\n1,\"2\n", "table.csv:2: error: a quote is not closed"},
      {"0,two\n", "table.csv:1: error: 'two' is not a finite number"},
      {std::string("\xFF\xFE"
                   "0\0,\0",
                   6),
       "table.csv:1: error: this is not a table of plain text"}};
  for (const auto& [content, message] : cases) {
    const std::string error = error_of(content);
    EXPECT_NE(error.find(message), std::string::npos) << content << "\n" << error;
  }
}

}  // namespace
}  // namespace copepod::coupler
