#include "analysis/coefficients.hpp"

#include <cmath>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "observers/trajectory_writer.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

constexpr std::int64_t shedding_steps = 4000;
constexpr double shedding_step_s = 0.003325, shedding_per_s = 1.7;

/// A ball and a rock in a stream along y, a body beside them, and an obstacle without loads.
LoadedCase shedding_case(std::int64_t from_step) {
  LoadedCase loaded;
  loaded.content.step_s = shedding_step_s;
  loaded.content.fluid.density_kg_per_m3 = 1000.0;
  loaded.content.output.trajectory_every_steps = 2;
  loaded.assembly.bodies.resize(2);
  loaded.assembly.bodies[0].name = "other";
  loaded.assembly.bodies[1].name = "ball";
  loaded.content.fluid.obstacles.resize(2);
  loaded.content.fluid.obstacles[0].name = "wall";
  loaded.content.fluid.obstacles[1].name = "rock";
  loaded.content.fluid.obstacles[1].loads = true;
  for (const char* of : {"ball", "rock"}) {
    Coefficients each;
    each.of = of;
    each.speed_m_per_s = 2.0;
    each.area_m2 = 0.01;
    each.length_m = 0.5;
    each.drag_axis = Eigen::Vector3d::UnitY();
    each.lift_axis = Eigen::Vector3d::UnitZ();
    each.from_step = from_step;
    loaded.content.output.coefficients.push_back(each);
  }
  return loaded;
}

/// Of a run in which drag 1.2 + 0.1 cos 2φ and lift 0.05 + amplitude sin φ act on the ball, and twice that on the rock;
/// φ = 2π f t. With ripples on the lift, and a start that would spoil every figure.
nlohmann::ordered_json report_of(double amplitude, std::int64_t from_step = 400) {
  const TemporaryFolder folder;
  const LoadedCase loaded = shedding_case(from_step);
  SampleWriter writer(folder.path("coefficients.csv"), coefficient_columns(loaded.content), shedding_step_s,
                      [&](const StepRecord& record) { return coefficients_in(record, loaded); }, {});
  Kinematics kinematics;
  kinematics.resize(2);
  const double unit_N = 0.5 * 1000.0 * 4.0 * 0.01;
  for (std::int64_t step = 0; step < shedding_steps; ++step) {
    const double phase = 2 * std::numbers::pi * shedding_per_s * shedding_step_s * static_cast<double>(step);
    Loads raw, applied, obstacles;
    raw.resize(2);
    applied.resize(2);
    obstacles.resize(1);
    applied.force_N.setConstant(1e9);
    raw.force_N.setConstant(1e9);
    const double lift = 0.05 + amplitude * (std::sin(phase) + 0.02 * std::sin(60 * phase));
    applied.force_N.col(1) = unit_N * Eigen::Vector3d(7.0, 1.2 + 0.1 * std::cos(2 * phase), lift);
    if (step < 400) applied.force_N.col(1) *= 50.0;
    obstacles.force_N = 2.0 * applied.force_N.col(1);
    writer.observe({step, kinematics, raw, applied, raw, obstacles});
  }
  const Loads none;
  writer.finish({shedding_steps, kinematics, none, none, none, none});
  return coefficient_report(folder.path("coefficients.csv"), loaded.content);
}

TEST(Coefficients, HaveTheFiguresOfAKnownOscillation) {
  const auto report = report_of(0.3);
  ASSERT_EQ(report.size(), 2U);
  for (const double factor : {1.0, 2.0}) {
    const auto& found = report[factor == 1.0 ? 0 : 1];
    EXPECT_EQ(found["name"], factor == 1.0 ? "ball" : "rock");
    EXPECT_NEAR(found["drag"]["mean"].get<double>(), factor * 1.2, 1e-4);
    EXPECT_NEAR(found["drag"]["rms"].get<double>(), factor * 0.1 / std::numbers::sqrt2, 1e-4);
    EXPECT_NEAR(found["drag"]["half_span"].get<double>(), factor * 0.1, 1e-4);
    EXPECT_NEAR(found["lift"]["mean"].get<double>(), factor * 0.05, 1e-3);
    EXPECT_NEAR(found["lift"]["half_span"].get<double>(), factor * 0.306, 1e-3);
    EXPECT_NEAR(found["strouhal"]["mean"].get<double>(), shedding_per_s * 0.5 / 2.0, 1e-4);
    EXPECT_LT(found["strouhal"]["half_span"].get<double>(), 0.01);
    EXPECT_EQ(found["strouhal"]["periods"], 19);  // of 20.3
  }
}

TEST(Coefficients, HaveNoStrouhalNumberWhereTheLiftIsSteady) {
  const auto found = report_of(1e-4)[0];
  EXPECT_TRUE(found["strouhal"].is_null());
  EXPECT_NEAR(found["lift"]["mean"].get<double>(), 0.05, 1e-5);
  EXPECT_NEAR(found["drag"]["mean"].get<double>(), 1.2, 3e-3);  // not of whole periods
}

TEST(Coefficients, HaveNoStrouhalNumberBeforeTwoPeriods) {
  EXPECT_EQ(report_of(0.3, shedding_steps - 530)[0]["strouhal"]["periods"], 2);
  EXPECT_TRUE(report_of(0.3, shedding_steps - 300)[0]["strouhal"].is_null());
}

TEST(Coefficients, OfARunThatEndsEarlierAreANote) {
  const auto found = report_of(0.3, 5000)[0];
  EXPECT_EQ(found["note"], "the run ended before step 5000");
  EXPECT_FALSE(found.contains("drag"));
}

TEST(FlowReport, HasTheFiguresOfEachColumnFromAStepOn) {
  const TemporaryFolder folder;
  std::ofstream(folder.path("flow.csv")) << "step,time_s,pz,wake.vx\n0,0,100,7\n10,0.5,1,-2\n20,1,3,-2e1\n30,1.5,5,1\n";
  const auto found = flow_report(folder.path("flow.csv"), {"pz", "wake.vx"}, 10);
  EXPECT_EQ(found[0], (nlohmann::ordered_json{
                          {"name", "pz"}, {"mean", 3.0}, {"rms", std::sqrt(8.0 / 3.0)}, {"min", 1.0}, {"max", 5.0}}));
  EXPECT_EQ(found[1]["mean"], -7.0);
  EXPECT_EQ(found[1]["min"], -20.0);
  EXPECT_EQ(found[1]["max"], 1.0);
  EXPECT_EQ(flow_report(folder.path("flow.csv"), {"pz", "wake.vx"}, 31)[1],
            (nlohmann::ordered_json{{"name", "wake.vx"}, {"note", "the run ended before step 31"}}));
}

}  // namespace
}  // namespace copepod::coupler
