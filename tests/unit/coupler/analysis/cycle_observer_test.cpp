#include "analysis/cycle_observer.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "analysis/as_in_paper.hpp"
#include "analysis/groups.hpp"
#include "analysis/rigid_fit.hpp"
#include "analysis/swimmer_report.hpp"
#include "contract/errors.hpp"

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
  for (std::size_t i = 0; i < 3; ++i) {
    swimmer.beads[i].name = std::array{"B2", "B1", "B3"}[i];
    swimmer.beads[i].position_m.z() = (static_cast<double>(i) - 1.0) * 16 * cell_m;
  }
  swimmer.three_beads = ThreeBeads{{8 * cell_m, 8 * cell_m}, {1e-5, period, period / 4, 3}};
  for (int i = 0; i < 2; ++i) {
    Arm& arm = swimmer.arms.emplace_back();
    arm.bead_A = i;
    arm.bead_B = i + 1;
    Signal& signal = arm.drive.emplace().signal;
    signal.kind = SignalKind::sinusoid;
    signal.period_steps = period;
    signal.start_step = i * period / 4;
    signal.stop_step = 3 * period + i * period / 4;
  }
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

std::vector<Group> groups_of(const Case& the_case) { return groups_of(the_case, assemble(the_case)); }

/// A made-up swimmer whose arms follow l̄ + d cos(ωt + φ) exactly, whose middle bead drifts at a steady speed along the
/// own axis, and which turns about `spin_axis` through its middle bead.
struct MadeUpMotion {
  double drift_cells_per_step = 1e-4;
  std::array<double, 2> mean{16.2, 15.9};
  std::array<double, 2> amplitude{2.5, 3.8};
  std::array<double, 2> phase{0.7, -0.6};
  double turn_rad_per_step = 0.0;
  Eigen::Vector3d spin_axis = Eigen::Vector3d::UnitX();

  [[nodiscard]] double arm(std::size_t i, double t) const {
    return mean[i] + amplitude[i] * std::cos(2 * pi * t / period + phase[i]);
  }
  [[nodiscard]] double arm_rate(std::size_t i, double t) const {
    return -amplitude[i] * 2 * pi / period * std::sin(2 * pi * t / period + phase[i]);
  }
  [[nodiscard]] Eigen::Matrix3d rotation(double t) const {
    return Eigen::AngleAxisd(turn_rad_per_step * t, spin_axis).toRotationMatrix();
  }
  [[nodiscard]] Kinematics at(std::int64_t step) const {
    const auto t = static_cast<double>(step);
    const double middle = drift_cells_per_step * t;
    Kinematics state;
    state.step = step;
    state.resize(3);
    state.position_m.setZero();
    state.position_m.row(2) << (middle - arm(0, t)) * cell_m, middle * cell_m, (middle + arm(1, t)) * cell_m;
    state.position_m = (rotation(t) * state.position_m).eval().array() + 50 * cell_m;
    state.velocity_m_per_s.setZero();
    state.velocity_m_per_s.row(2) << drift_cells_per_step - arm_rate(0, t), drift_cells_per_step,
        drift_cells_per_step + arm_rate(1, t);
    state.velocity_m_per_s *= cell_m / step_s;
    state.angular_velocity_rad_per_s.setConstant(3, 3, 7.0);
    return state;
  }
};

Loads constant_forces(double trailing, double middle, double leading) {
  Loads drive;
  drive.force_N.setZero(3, 3);
  drive.torque_N_m.setZero(3, 3);
  drive.force_N.row(2) << trailing, middle, leading;
  return drive;
}

Loads loads(const Eigen::Vector3d& force_N, const Eigen::Vector3d& torque_N_m) {
  Loads loads;
  loads.resize(3);
  loads.force_N.colwise() = force_N;
  loads.torque_N_m.colwise() = torque_N_m;
  return loads;
}

void play(CycleObserver& observer, const MadeUpMotion& motion, const Loads& driving, std::int64_t stop,
          std::int64_t start = 0, const Loads& applied = loads({0, 0, 0}, {0, 0, 0})) {
  for (std::int64_t step = start; step < stop; ++step)
    observer.observe({step, motion.at(step), applied, applied, driving});
}

void finish(CycleObserver& observer, const MadeUpMotion& motion, const Loads& driving, std::int64_t step) {
  const Loads applied = loads({0, 0, 0}, {0, 0, 0});
  observer.finish({step, motion.at(step), applied, applied, driving});
}

/// The last cycle of a swimmer that moves so.
Cycle measured(const MadeUpMotion& motion, const Loads& driving, const Swimmer& swimmer = three_spheres(),
               const Loads& applied = loads({0, 0, 0}, {0, 0, 0})) {
  CycleObserver observer(groups_of(case_of(swimmer)));
  play(observer, motion, driving, 3 * period + 50, 0, applied);
  return observer.sums()[0].last;
}

TEST(CycleObserver, RecoversAmplitudesPhasesAndMeansOfTheArms) {
  const MadeUpMotion motion;
  const Cycle cycle = measured(motion, constant_forces(0, 0, 0));
  EXPECT_EQ(cycle.number, 2);
  for (std::size_t arm = 0; arm < 2; ++arm) {
    const Eigen::Vector3d fit = cycle.arms.col(static_cast<Eigen::Index>(arm));
    EXPECT_NEAR(fit[0] / cell_m, motion.mean[arm], 1e-9);
    EXPECT_NEAR(fit[1] / cell_m, motion.amplitude[arm], 1e-9);
    EXPECT_NEAR(fit[2], motion.phase[arm], 1e-9);
  }
  EXPECT_NEAR(cycle.translation_m.z() / cell_m / period, motion.drift_cells_per_step, 1e-12);
  EXPECT_LT(rotation_vector(cycle.rotation).norm(), 1e-12);
}

TEST(CycleObserver, TakesTheFastestMomentOfEachBead) {
  MadeUpMotion motion;
  motion.phase = {0.0, 0.0};
  const Eigen::VectorXd fastest = measured(motion, constant_forces(0, 0, 0)).max_speed_m_per_s * step_s / cell_m;
  const double omega = 2 * pi / period;
  EXPECT_NEAR(fastest[0], 1e-4 + 2.5 * omega, 1e-12);
  EXPECT_NEAR(fastest[1], 1e-4, 1e-15);
  EXPECT_NEAR(fastest[2], 1e-4 + 3.8 * omega, 1e-12);
}

TEST(CycleObserver, AveragesThePowerOfTheDriveAndThatGivenToTheFluid) {
  // Oscillating parts cancel over a whole period, the drift does not: P = (F₂ + F₁ + F₃) u.
  const Cycle cycle = measured(MadeUpMotion{}, constant_forces(-2e-5, 5e-5, 7e-5), three_spheres(),
                               loads({1e-5, 1e-5, -4e-5}, {0, -2e-12, 0}));
  EXPECT_NEAR(cycle.power_W / (10e-5 * 1e-4 * cell_m / step_s), 1.0, 1e-10);
  EXPECT_NEAR(cycle.dissipation_W / (3 * 4e-5 * 1e-4 * cell_m / step_s + 3 * 7.0 * 2e-12), 1.0, 1e-10);
}

TEST(CycleObserver, EvaluatesThePowerOfThePapersTablesWhereFiguresArePublished) {
  Swimmer swimmer = three_spheres();
  swimmer.three_beads->stroke.phase_lag_steps = 0;
  MadeUpMotion motion;
  motion.drift_cells_per_step = 0.0;
  EXPECT_FALSE(measured(motion, constant_forces(0, 0, 0), swimmer).power_as_in_paper_W);
  swimmer.published = {{"K", 1.0}};
  const Cycle cycle = measured(motion, constant_forces(0, 0, 0), swimmer);
  EXPECT_EQ(cycle.power_W, 0.0);
  const double omega = rounded_omega_per_step(period);
  EXPECT_DOUBLE_EQ(omega, 0.016);  // 2π/400 = 0.01571
  double expected = 0.0;
  for (std::int64_t step = 2 * period; step < 3 * period; ++step) {
    const double force = 1e-5 * std::sin(omega * static_cast<double>(step));
    const auto t = static_cast<double>(step);
    expected += force * (motion.arm_rate(0, t) + motion.arm_rate(1, t)) * cell_m / step_s / period;
  }
  EXPECT_NEAR(cycle.power_as_in_paper_W.value() / expected, 1.0, 1e-9);
}

TEST(CycleObserver, CarriesTheOwnAxisAlongATurningSwimmer) {
  MadeUpMotion motion;
  motion.turn_rad_per_step = 0.5 / period;
  const Case the_case = case_of(three_spheres());
  CycleObserver observer(groups_of(the_case));
  play(observer, motion, constant_forces(0, 0, 0), 3 * period + 1);
  const Cycle& cycle = observer.sums()[0].last;
  const CycleFigures figures = evaluate(cycle, observer.groups()[0], the_case.fluid, step_s);
  EXPECT_LT((figures.axis - motion.rotation(2 * period) * Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((figures.rotation_rad - 0.5 * Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_NEAR(figures.tilt_rad, 1.0, 1e-12);
  // The centroid goes from c(2T) to c(3T), each along the axis of its time.
  const auto centroid = [&](std::int64_t step) { return motion.at(step).position_m.rowwise().mean().eval(); };
  const Eigen::Vector3d velocity = (centroid(3 * period) - centroid(2 * period)) / (period * step_s);
  EXPECT_LT((figures.velocity_m_per_s - velocity).norm(), 1e-12 * velocity.norm());
  EXPECT_NEAR(figures.along_m_per_s / velocity.dot(figures.axis), 1.0, 1e-10);
  EXPECT_LT(std::abs(figures.across_m_per_s.dot(figures.axis)), 1e-12 * velocity.norm());
  // A motion that is the same from cycle to cycle but for its direction does not change in the own frame.
  EXPECT_LT(*change(observer.sums()[0].before_last, cycle).rotation, 1e-10);
}

TEST(CycleObserver, MeasuresTheHelixOfASwimmerThatRollsAndPitches) {
  // Four beads, rigid, that advance by `pitch` and turn by `angle` about a fixed direction in every cycle.
  const Eigen::Vector3d about = Eigen::Vector3d(1, 2, 3).normalized();
  const double angle = 0.4, pitch_m = 2e-6, radius_m = 5e-6;
  Group group;
  group.name = "helix";
  group.bodies = {0, 1, 2, 3};
  group.axis = Eigen::Vector3d::UnitX();
  group.placed_m = Eigen::Matrix3Xd::Zero(3, 4);
  group.placed_m << 4e-6, 0, 0, -1e-6, 0, 3e-6, 0, 0, 0, 0, 2e-6, 0;
  group.period_steps = 10;
  group.stop_cycle = 6;
  group.length_m = group.radius_m = 1e-5;
  const Eigen::Vector3d arm_m = radius_m * about.unitOrthogonal();
  const Eigen::Matrix3Xd shape_m = group.placed_m;
  const auto state_at = [&](std::int64_t step) {
    const double cycles = static_cast<double>(step) / 10.0;
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(angle * cycles, about).toRotationMatrix();
    Kinematics state;
    state.resize(4);
    state.position_m = (turned * shape_m).colwise() + (turned * arm_m - arm_m + cycles * pitch_m * about);
    state.velocity_m_per_s.setZero();
    state.angular_velocity_rad_per_s.setZero();
    return state;
  };
  CycleObserver observer({group});
  Loads none;
  none.resize(4);
  none.force_N.setZero();
  none.torque_N_m.setZero();
  for (std::int64_t step = 0; step <= 60; ++step) observer.observe({step, state_at(step), none, none, none});
  const Cycle& cycle = observer.sums()[0].last;
  ASSERT_EQ(cycle.number, 5);
  const CycleFigures figures = evaluate(cycle, group, FluidCase{}, step_s);
  EXPECT_LT((figures.rotation_rad - angle * about).norm(), 1e-12);
  EXPECT_LT((figures.axis - Eigen::AngleAxisd(5 * angle, about) * group.axis).norm(), 1e-12);
  EXPECT_NEAR(cycle.translation_m.dot(about) / pitch_m, 1.0, 1e-9);
  // The chord of the circle that the centroid runs on, seen along its axis.
  const Eigen::Vector3d centroid = shape_m.rowwise().mean() + arm_m;
  const double circle_m = (centroid - centroid.dot(about) * about).norm();
  const double chord_m = (cycle.translation_m - cycle.translation_m.dot(about) * about).norm();
  EXPECT_NEAR(chord_m / (2 * circle_m * std::sin(angle / 2)), 1.0, 1e-9);
  const CycleChange changed = change(observer.sums()[0].before_last, cycle);
  EXPECT_LT(*changed.velocity, 1e-9);
  EXPECT_LT(*changed.rotation, 1e-9);
}

TEST(CycleObserver, MeasuresFullCyclesOnly) {
  CycleObserver observer(groups_of(case_of(three_spheres())));
  play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), 3 * period);
  EXPECT_EQ(observer.sums()[0].last.number, 1);
  const auto report = swimmer_reports(case_of(three_spheres()), observer)["swimmers"][0];
  EXPECT_FALSE(report["analysed"].get<bool>());
  EXPECT_TRUE(report["u_swim_lattice"].is_null());
  EXPECT_EQ(report["kinematics"]["cycle"], 1);
  finish(observer, MadeUpMotion{}, constant_forces(0, 0, 0), 3 * period);
  EXPECT_EQ(observer.sums()[0].last.number, 2);
}

TEST(CycleObserver, MeasuresNothingBeyondTheDrive) {
  Swimmer swimmer = three_spheres();
  swimmer.arms[0].drive->signal.start_step = swimmer.arms[1].drive->signal.start_step = period + 1;
  swimmer.arms[1].drive->signal.stop_step = 4 * period - 1;
  swimmer.arms[0].drive->signal.stop_step = Signal::never;
  CycleObserver observer(groups_of(case_of(swimmer)));
  play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), 2 * period + 1);
  EXPECT_EQ(observer.sums()[0].last.number, -1);
  play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), 5 * period, 2 * period + 1);
  EXPECT_EQ(observer.sums()[0].last.number, 2);
}

TEST(CycleObserver, HasNoCyclesWithoutAPeriodicDriveAndTheLongestOfSeveralPeriods) {
  Swimmer swimmer = three_spheres();
  swimmer.arms[0].drive->signal.period_steps = 2 * period;
  EXPECT_EQ(groups_of(case_of(swimmer))[0].period_steps, 2 * period);
  EXPECT_NE(groups_of(case_of(swimmer))[0].note.find("cycles are those of the longest"), std::string::npos);
  for (Arm& arm : swimmer.arms) arm.drive.reset();
  const auto groups = groups_of(case_of(swimmer));
  EXPECT_NE(groups[0].note.find("no cycles to measure"), std::string::npos);
  CycleObserver observer(groups);
  play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), 3 * period);
  EXPECT_TRUE(swimmer_reports(case_of(swimmer), observer)["swimmers"][0]["kinematics"]["cycle"].is_null());
}

TEST(CycleObserver, MeasuresNamedGroupsOfBodiesLikeSwimmers) {
  Case the_case = case_of(three_spheres());
  the_case.groups.push_back({"group", {"swimmer.B2", "swimmer.B1", "swimmer.B3"}, Eigen::Vector3d::UnitZ(), 0});
  the_case.groups.push_back({"front", {"swimmer.B3", "swimmer.B1"}, Eigen::Vector3d::UnitX(), period});
  the_case.groups.push_back({"idle", {"swimmer.B2"}, Eigen::Vector3d::UnitZ(), 0});
  the_case.groups.push_back({"bead", {"swimmer.B2"}, Eigen::Vector3d::UnitZ(), 2 * period});
  const auto groups = groups_of(the_case);
  ASSERT_EQ(groups.size(), 5U);
  EXPECT_EQ(groups[1].arms, groups[0].arms);
  EXPECT_EQ(groups[2].arms, (std::vector<std::array<int, 2>>{{1, 2}}));
  EXPECT_EQ(groups[2].first_cycle, 1);   // the drive of its one arm starts after a quarter of a period
  EXPECT_EQ(groups[3].period_steps, 0);  // nothing drives that bead alone
  EXPECT_EQ(groups[4].period_steps, 2 * period);
  EXPECT_NEAR(groups[3].length_m / cell_m, 8.0, 1e-12);
  CycleObserver observer(groups);
  MadeUpMotion motion;
  motion.turn_rad_per_step = 1e-4;
  play(observer, motion, constant_forces(1e-5, 0, -1e-5), 3 * period + 1);
  EXPECT_EQ(observer.sums()[1].last.arms, observer.sums()[0].last.arms);
  EXPECT_EQ(observer.sums()[1].last.power_W, observer.sums()[0].last.power_W);
  EXPECT_EQ(observer.sums()[1].turned, observer.sums()[0].turned);
  const auto reports = swimmer_reports(the_case, observer);
  EXPECT_EQ(reports["groups"][0]["kinematics"], reports["swimmers"][0]["kinematics"]);
  EXPECT_EQ(reports["groups"][1]["kinematics"]["arms"][0]["bodies"][1], "swimmer.B3");
  EXPECT_EQ(reports["groups"][3]["kinematics"]["cycle"], 0);
  EXPECT_FALSE(reports.contains("swarm"));
}

TEST(CycleObserver, ContinuesFromRestoredSumsBitForBit) {
  MadeUpMotion motion;
  motion.turn_rad_per_step = 1e-4;
  const Loads driving = constant_forces(1e-5, 2e-5, 3e-5);
  const auto groups = groups_of(case_of(three_spheres()));
  CycleObserver whole(groups);
  play(whole, motion, driving, 3 * period + 1);
  for (const std::int64_t cut : {2 * period + 123, 2 * period, 2 * period + 1}) {
    CycleObserver first(groups), second(groups);
    play(first, motion, driving, cut);
    second.restore(first.sums());
    play(second, motion, driving, 3 * period + 1, cut);
    EXPECT_EQ(whole.sums()[0].last.arms, second.sums()[0].last.arms);
    EXPECT_EQ(whole.sums()[0].last.power_W, second.sums()[0].last.power_W);
    EXPECT_EQ(whole.sums()[0].last.turned, second.sums()[0].last.turned);
    EXPECT_EQ(whole.sums()[0].turned, second.sums()[0].turned);
  }
}

TEST(CycleObserver, RefusesTheSumsOfOtherSwimmers) {
  CycleObserver one(groups_of(case_of(three_spheres())));
  play(one, MadeUpMotion{}, constant_forces(0, 0, 0), 10);
  Swimmer pair = three_spheres();
  pair.arms.pop_back();
  CycleObserver other(groups_of(case_of(pair)));
  EXPECT_THROW(other.restore(one.sums()), StorageError);
  EXPECT_THROW(other.restore({}), StorageError);
}

TEST(CycleTable, HasARowPerCycleAndContinuesWithoutDoubleRows) {
  const auto path = std::filesystem::path(testing::TempDir()) / "cycles.csv";
  std::filesystem::remove(path);
  const Case the_case = case_of(three_spheres());
  const auto lines = [&] {
    std::vector<std::string> found;
    std::ifstream stream(path);
    for (std::string line; std::getline(stream, line);) found.push_back(line);
    return found;
  };
  const auto play_from = [&](std::int64_t start, std::int64_t stop, const CycleObserver* before) {
    CycleObserver observer(groups_of(the_case));
    CycleTable table(path.string(), observer.groups(), the_case.fluid, step_s, start);
    observer.write_to(table);
    if (before != nullptr) observer.restore(before->sums());
    play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), stop, start);
  };
  play_from(0, 3 * period + 1, nullptr);
  const auto whole = lines();
  ASSERT_EQ(whole.size(), 4U);
  EXPECT_TRUE(
      whole[0].ends_with("Re,arm1_mean_m,arm1_amplitude_m,arm1_phase_rad,arm2_mean_m,arm2_amplitude_m,"
                         "arm2_phase_rad"));
  EXPECT_TRUE(whole[1].starts_with("swimmer,0,0,0,"));
  EXPECT_TRUE(whole[3].starts_with("swimmer,2,800,"));
  for (const std::string& line : whole)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(whole[0].begin(), whole[0].end(), ','));
  // A run that ended later than its checkpoint has left rows that will be computed again. The cycle that ends at step T
  // is measured in that step, after the checkpoint of step T.
  for (const std::int64_t cut : {period - 1, period, period + 1, 2 * period + 5}) {
    CycleObserver before(groups_of(the_case));
    play(before, MadeUpMotion{}, constant_forces(0, 0, 0), cut);
    play_from(cut, 3 * period + 1, &before);
    EXPECT_EQ(lines(), whole) << cut;
  }
}

TEST(SwimmerReport, PrintsTheRowOfThePapersTablesInLatticeUnits) {
  Swimmer swimmer = three_spheres();
  swimmer.published = {{"K", 1.0}};
  CycleObserver observer(groups_of(case_of(swimmer)));
  play(observer, MadeUpMotion{}, constant_forces(-1e-5, 0, 1e-5), 3 * period + 1);
  const auto report = swimmer_reports(case_of(swimmer), observer)["swimmers"][0];
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

TEST(SwimmerReport, EvaluatesThePapersWayOnlyWhereFiguresArePublished) {
  CycleObserver observer(groups_of(case_of(three_spheres())));
  play(observer, MadeUpMotion{}, constant_forces(-1e-5, 0, 1e-5), 3 * period + 1);
  const auto report = swimmer_reports(case_of(three_spheres()), observer)["swimmers"][0];
  EXPECT_TRUE(report["analysed"].get<bool>());
  EXPECT_FALSE(report.contains("as_in_paper"));
}

TEST(SwimmerReport, MeasuresTheSpeedOfATurnedSwimmerAlongItsOwnAxis) {
  Swimmer swimmer = three_spheres();
  swimmer.orientation_wxyz = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};  // z to −y
  CycleObserver observer(groups_of(case_of(swimmer)));
  for (std::int64_t step = 0; step <= 3 * period; ++step) {
    Kinematics state = MadeUpMotion{}.at(step);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
    state.position_m = (turn * state.position_m).eval();
    const Loads none = loads({0, 0, 0}, {0, 0, 0});
    observer.observe({step, state, none, none, constant_forces(0, 0, 0)});
  }
  const auto report = swimmer_reports(case_of(swimmer), observer)["swimmers"][0];
  EXPECT_NEAR(report["u_swim_lattice"].get<double>(), 1e-4, 1e-12);
  EXPECT_NEAR(report["kinematics"]["u_along_cells_per_step"].get<double>(), 1e-4, 1e-12);
  EXPECT_NEAR(report["kinematics"]["u_along_um_per_s"].get<double>(), 1e6 * 1e-4 * cell_m / step_s, 1e-6);
  EXPECT_NEAR(report["kinematics"]["u_along_lengths_per_cycle"].get<double>(), 1e-4 * period / 40, 1e-12);
  EXPECT_NEAR(report["kinematics"]["u_across_cells_per_step"].get<double>(), 0.0, 1e-16);
  EXPECT_NEAR(report["kinematics"]["Re"].get<double>(), report["Re_swim"].get<double>(), 1e-12);
  EXPECT_NEAR(report["kinematics"]["tilt_rad"].get<double>(), 0.0, 1e-12);
  EXPECT_EQ(report["kinematics"]["arms"][1]["bodies"][0], "swimmer.B1");
}

TEST(SwimmerReport, HasNoReynoldsNumbersInVacuumAndNoCellsWithoutALattice) {
  Case vacuum = case_of(three_spheres());
  vacuum.fluid = {};
  CycleObserver observer(groups_of(vacuum));
  play(observer, MadeUpMotion{}, constant_forces(-1e-5, 0, 1e-5), 3 * period + 1);
  const auto report = swimmer_reports(vacuum, observer)["swimmers"][0];
  EXPECT_TRUE(report["Re_swim"].is_null());
  EXPECT_TRUE(report["Re_bodies"]["B1"].is_null());
  EXPECT_TRUE(report["efficiency"].is_null());
  EXPECT_TRUE(report["kinematics"]["efficiency"].is_null());
  EXPECT_TRUE(report["u_swim_lattice"].is_null());
  EXPECT_FALSE(report["u_swim_m_per_s"].is_null());
}

TEST(SwimmerReport, DescribesASwarm) {
  Case the_case = case_of(three_spheres());
  EXPECT_FALSE(swimmer_reports(the_case, CycleObserver(groups_of(the_case))).contains("swarm"));
  Swimmer other = three_spheres();
  other.name = "other";
  other.orientation_wxyz = {std::sqrt(0.5), -std::sqrt(0.5), 0, 0};  // z to y
  the_case.swimmers.push_back(other);
  the_case.fluid.domain_cells = {100, 100, 100};
  for (Boundary& face : the_case.fluid.boundaries) face.kind = BoundaryKind::periodic;
  CycleObserver observer(groups_of(the_case));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(-pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  MadeUpMotion slow, fast;
  for (MadeUpMotion* motion : {&slow, &fast}) {
    motion->mean = motion->amplitude = {2, 2};  // at the end of a cycle, the centroid is the middle bead
    motion->phase = {0, 0};
  }
  fast.drift_cells_per_step = 3e-4;
  Loads none;
  none.resize(6);
  none.force_N.setZero();
  none.torque_N_m.setZero();
  for (std::int64_t step = 0; step <= 3 * period; ++step) {
    const Eigen::Vector3d start_m = Eigen::Vector3d::Constant(50 * cell_m);
    const Eigen::Matrix3Xd moved_m = turn * (fast.at(step).position_m.colwise() - start_m);
    Kinematics both;
    both.resize(6);
    both.position_m << slow.at(step).position_m, moved_m.colwise() + (start_m + Eigen::Vector3d(95 * cell_m, 0, 0));
    both.velocity_m_per_s.setZero();
    both.angular_velocity_rad_per_s.setZero();
    observer.observe({step, both, none, none, none});
  }
  const auto swarm = swimmer_reports(the_case, observer)["swarm"];
  EXPECT_EQ(swarm["swimmers"], 2);
  EXPECT_NEAR(swarm["u_along_mean_m_per_s"].get<double>() * step_s / cell_m, 2e-4, 1e-12);
  EXPECT_NEAR(swarm["u_along_spread_m_per_s"].get<double>() * step_s / cell_m, 1e-4, 1e-12);
  EXPECT_NEAR(swarm["polar_order"].get<double>(), std::sqrt(0.5), 1e-9);
  const double distance_m = std::sqrt(25 + 0.12 * 0.12 + 0.36 * 0.36) * cell_m;  // across the periodic face
  EXPECT_NEAR(swarm["nearest_distance_least_m"].get<double>() / distance_m, 1.0, 1e-9);
  EXPECT_NEAR(swarm["nearest_distance_mean_m"].get<double>() / distance_m, 1.0, 1e-9);
}

}  // namespace
}  // namespace copepod::coupler
