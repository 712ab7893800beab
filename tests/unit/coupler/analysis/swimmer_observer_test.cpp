#include "analysis/swimmer_observer.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "analysis/as_in_paper.hpp"
#include "analysis/swimmer_report.hpp"

namespace copepod::coupler {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::int64_t period = 400;
constexpr double cell_m = 1e-6;
constexpr double step_s = 7.5e-10;

Swimmer three_spheres() {
  Swimmer swimmer;
  swimmer.name = "swimmer";
  Bead bead;
  bead.shape = {ShapeKind::sphere, 4 * cell_m, 0.0};
  bead.mass_kg = 5.44e-13;
  swimmer.beads = {bead, bead, bead};
  swimmer.three_beads = ThreeBeads{{8 * cell_m, 8 * cell_m}, {1e-5, period, period / 4, 3}};
  return swimmer;
}

Case case_of(const Swimmer& swimmer) {
  Case the_case;
  the_case.fluid.density_kg_per_m3 = 1360;
  the_case.fluid.kinematic_viscosity_m2_per_s = 7.36e-5;
  the_case.fluid.cell_size_m = cell_m;
  the_case.step_s = step_s;
  the_case.swimmers = {swimmer};
  return the_case;
}

/// A made-up swimmer whose arms follow l̄ + d cos(ωt + φ) exactly and whose middle bead drifts at a
/// steady speed.
struct MadeUpMotion {
  double drift_cells_per_step = 1e-4;
  std::array<double, 2> mean{16.2, 15.9};
  std::array<double, 2> amplitude{2.5, 3.8};
  std::array<double, 2> phase{0.7, -0.6};

  [[nodiscard]] double arm(std::size_t i, double t) const {
    return mean[i] + amplitude[i] * std::cos(2 * pi * t / period + phase[i]);
  }
  [[nodiscard]] double arm_rate(std::size_t i, double t) const {
    return -amplitude[i] * 2 * pi / period * std::sin(2 * pi * t / period + phase[i]);
  }
  [[nodiscard]] Kinematics at(std::int64_t step) const {
    const auto t = static_cast<double>(step);
    const double middle = 100.0 + drift_cells_per_step * t;
    Kinematics state;
    state.step = step;
    state.resize(3);
    state.position_m.setConstant(50 * cell_m);
    state.position_m.row(2) << (middle - arm(0, t)) * cell_m, middle * cell_m, (middle + arm(1, t)) * cell_m;
    state.velocity_m_per_s.setZero();
    state.velocity_m_per_s.row(2) << drift_cells_per_step - arm_rate(0, t), drift_cells_per_step,
        drift_cells_per_step + arm_rate(1, t);
    state.velocity_m_per_s *= cell_m / step_s;
    return state;
  }
};

Eigen::Matrix3Xd constant_forces(double trailing, double middle, double leading) {
  Eigen::Matrix3Xd force = Eigen::Matrix3Xd::Zero(3, 3);
  force.row(2) << trailing, middle, leading;
  return force;
}

void play(SwimmerObserver& observer, const MadeUpMotion& motion, const Eigen::Matrix3Xd& driving, std::int64_t steps) {
  const Loads none;
  for (std::int64_t step = 0; step < steps; ++step) observer.observe({step, motion.at(step), none, none, driving});
  observer.finish({steps, motion.at(steps), none, none, driving});
}

TEST(SwimmerObserver, RecoversAmplitudesPhasesAndMeansOfTheArms) {
  SwimmerObserver observer(three_spheres(), 0);
  const MadeUpMotion motion;
  play(observer, motion, constant_forces(0, 0, 0), 3 * period + 50);
  const auto measured = observer.measurement();
  ASSERT_TRUE(measured);
  for (std::size_t arm = 0; arm < 2; ++arm) {
    EXPECT_NEAR(measured->arms[arm].amplitude_m / cell_m, motion.amplitude[arm], 1e-9);
    EXPECT_NEAR(measured->arms[arm].phase_rad, motion.phase[arm], 1e-9);
    EXPECT_NEAR(measured->arms[arm].mean_m / cell_m, motion.mean[arm], 1e-9);
  }
  EXPECT_NEAR(measured->displacement_m / cell_m / period, motion.drift_cells_per_step, 1e-12);
}

TEST(SwimmerObserver, TakesTheFastestMomentOfEachBead) {
  SwimmerObserver observer(three_spheres(), 0);
  MadeUpMotion motion;
  motion.phase = {0.0, 0.0};
  play(observer, motion, constant_forces(0, 0, 0), 3 * period);
  const auto measured = observer.measurement();
  ASSERT_TRUE(measured);
  const double to_lattice = step_s / cell_m;
  const double omega = 2 * pi / period;
  EXPECT_NEAR(measured->max_speed_m_per_s[0] * to_lattice, 1e-4 + 2.5 * omega, 1e-12);
  EXPECT_NEAR(measured->max_speed_m_per_s[1] * to_lattice, 1e-4, 1e-15);
  EXPECT_NEAR(measured->max_speed_m_per_s[2] * to_lattice, 1e-4 + 3.8 * omega, 1e-12);
}

TEST(SwimmerObserver, AveragesThePowerOfTheDrivingForcesOverThePeriod) {
  SwimmerObserver observer(three_spheres(), 0);
  const MadeUpMotion motion;
  play(observer, motion, constant_forces(-2e-5, 5e-5, 7e-5), 3 * period);
  const auto measured = observer.measurement();
  ASSERT_TRUE(measured);
  // Oscillating parts cancel over a whole period, the drift does not: P = (F₂ + F₁ + F₃) u.
  EXPECT_NEAR(measured->mean_power_W / (10e-5 * 1e-4 * cell_m / step_s), 1.0, 1e-10);
}

TEST(SwimmerObserver, EvaluatesThePowerWithRoundedOmegaFromForcesOutOfPhase) {
  Swimmer swimmer = three_spheres();
  swimmer.three_beads->stroke.phase_lag_steps = 0;
  SwimmerObserver observer(swimmer, 0);
  MadeUpMotion motion;
  motion.drift_cells_per_step = 0.0;
  play(observer, motion, constant_forces(0, 0, 0), 3 * period);
  const auto measured = observer.measurement();
  ASSERT_TRUE(measured);
  EXPECT_EQ(measured->mean_power_W, 0.0);
  const double omega = rounded_omega_per_step(period);
  EXPECT_DOUBLE_EQ(omega, 0.016);  // 2π/400 = 0.01571
  double expected = 0.0;
  for (std::int64_t step = 2 * period; step < 3 * period; ++step) {
    const double force = 1e-5 * std::sin(omega * static_cast<double>(step));
    const auto t = static_cast<double>(step);
    expected += force * (motion.arm_rate(0, t) + motion.arm_rate(1, t)) * cell_m / step_s / period;
  }
  EXPECT_NEAR(measured->mean_power_rounded_omega_W / expected, 1.0, 1e-9);
}

TEST(SwimmerObserver, SaysNothingWhenTheRunEndsBeforeThePeriodDoes) {
  SwimmerObserver observer(three_spheres(), 0);
  play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), 3 * period - 1);
  EXPECT_FALSE(observer.measurement());
  const auto report = swimmer_report(three_spheres(), observer, case_of(three_spheres()));
  EXPECT_FALSE(report["analysed"].get<bool>());
  EXPECT_TRUE(report["u_swim_lattice"].is_null());
}

TEST(SwimmerObserver, ContinuesFromRestoredSumsBitForBit) {
  const MadeUpMotion motion;
  const Eigen::Matrix3Xd driving = constant_forces(1e-5, 2e-5, 3e-5);
  SwimmerObserver whole(three_spheres(), 0);
  play(whole, motion, driving, 3 * period);
  SwimmerObserver first(three_spheres(), 0);
  const Loads none;
  const std::int64_t cut = 2 * period + 123;
  for (std::int64_t step = 0; step < cut; ++step) first.observe({step, motion.at(step), none, none, driving});
  SwimmerObserver second(three_spheres(), 0);
  second.restore(first.sums());
  for (std::int64_t step = cut; step < 3 * period; ++step) second.observe({step, motion.at(step), none, none, driving});
  second.finish({3 * period, motion.at(3 * period), none, none, driving});
  ASSERT_TRUE(second.measurement());
  EXPECT_EQ(whole.measurement()->arms[0].amplitude_m, second.measurement()->arms[0].amplitude_m);
  EXPECT_EQ(whole.measurement()->mean_power_W, second.measurement()->mean_power_W);
}

TEST(SwimmerReport, PrintsTheRowOfThePapersTablesInLatticeUnits) {
  SwimmerObserver observer(three_spheres(), 0);
  const MadeUpMotion motion;
  play(observer, motion, constant_forces(-1e-5, 0, 1e-5), 3 * period);
  const auto report = swimmer_report(three_spheres(), observer, case_of(three_spheres()));
  EXPECT_EQ(report["name"], "swimmer");
  EXPECT_NEAR(report["u_swim_lattice"].get<double>(), 1e-4, 1e-12);
  EXPECT_NEAR(report["d1_cells"].get<double>(), 2.5, 1e-9);
  EXPECT_NEAR(report["d2_cells"].get<double>(), 3.8, 1e-9);
  EXPECT_NEAR(report["sin_dphi"].get<double>(), std::sin(1.3), 1e-9);
  EXPECT_NEAR(report["mean_arm_cells"][0].get<double>(), 16.2, 1e-9);
  const double K = 3.0 * 64 / (2.0 * 144) * (1 / (16.2 * 16.2) + 1 / (15.9 * 15.9) - 1 / (32.1 * 32.1));
  EXPECT_NEAR(report["K"].get<double>(), K, 1e-12);
  EXPECT_NEAR(report["u_GA_lattice"].get<double>(), K * 2.5 * 3.8 * 2 * pi / period * std::sin(1.3), 1e-12);
  EXPECT_NEAR(report["as_in_paper"]["u_GA_lattice"].get<double>(), K * 2.5 * 3.8 * 0.016 * std::sin(1.3), 1e-12);
  EXPECT_EQ(report["as_in_paper"]["Re_bodies"]["B2"], report["Re_bodies"]["B1"]);
  EXPECT_EQ(report["as_in_paper"]["Re_bodies"]["B1"], report["Re_bodies"]["B2"]);
  EXPECT_EQ(report["as_in_paper"]["Re_bodies"]["B3"], report["Re_bodies"]["B3"]);
}

TEST(SwimmerReport, HasNoReynoldsNumbersInVacuumAndNoCellsWithoutALattice) {
  SwimmerObserver observer(three_spheres(), 0);
  play(observer, MadeUpMotion{}, constant_forces(-1e-5, 0, 1e-5), 3 * period);
  Case vacuum = case_of(three_spheres());
  vacuum.fluid = {};
  const auto report = swimmer_report(three_spheres(), observer, vacuum);
  EXPECT_TRUE(report["Re_swim"].is_null());
  EXPECT_TRUE(report["Re_bodies"]["B1"].is_null());
  EXPECT_TRUE(report["efficiency"].is_null());
  EXPECT_TRUE(report["u_swim_lattice"].is_null());
  EXPECT_FALSE(report["u_swim_m_per_s"].is_null());
}

}  // namespace
}  // namespace copepod::coupler
