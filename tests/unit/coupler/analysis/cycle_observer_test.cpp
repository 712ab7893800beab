#include "analysis/cycle_observer.hpp"

#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "analysis/made_up_motion.hpp"
#include "analysis/swimmer_figures.hpp"
#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

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
  const auto lag = static_cast<double>(swimmer.three_beads->stroke.phase_lag_steps);
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
    const auto t = static_cast<double>(step);
    const double force_1 = 1e-5 * std::sin(omega * t), force_2 = 1e-5 * std::sin(omega * (t - lag));
    expected += (force_1 * motion.arm_rate(0, t) + force_2 * motion.arm_rate(1, t)) * cell_m / step_s / period;
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
  EXPECT_LT(*change(observer.sums()[0].before_last, cycle, 1e-5).rotation, 1e-10);
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
  group.length_m = 1e-5;
  group.radii_m = {1e-5};
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
  for (std::int64_t step = 0; step <= 60; ++step) observer.observe({step, state_at(step), none, none, none, none});
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
  const CycleChange changed = change(observer.sums()[0].before_last, cycle, group.length_m);
  EXPECT_LT(*changed.velocity, 1e-9);
  EXPECT_LT(*changed.rotation, 1e-9);
}

TEST(CycleObserver, CarriesTheOwnAxisThroughRotationsAboutDifferentAxes) {
  Group group;
  group.bodies = {0, 1, 2, 3};
  group.placed_m = Eigen::Matrix3Xd::Zero(3, 4);
  group.placed_m << 4, 0, 0, -1, 0, 3, 0, 0, 0, 0, 2, 0;
  group.period_steps = 1;
  group.stop_cycle = 3;
  group.length_m = 1.0;
  const Eigen::Matrix3d about_x = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Matrix3d about_y = Eigen::AngleAxisd(0.9, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const std::array<Eigen::Matrix3d, 3> turned{Eigen::Matrix3d::Identity(), about_x, about_y * about_x};
  CycleObserver observer({group});
  const Loads none = [] {
    Loads loads;
    loads.force_N.setZero(3, 4);
    loads.torque_N_m.setZero(3, 4);
    return loads;
  }();
  for (std::size_t step = 0; step < turned.size(); ++step) {
    Kinematics state;
    state.resize(4);
    state.position_m = turned[step] * group.placed_m;
    state.velocity_m_per_s.setZero();
    state.angular_velocity_rad_per_s.setZero();
    observer.observe({static_cast<std::int64_t>(step), state, none, none, none, none});
  }
  EXPECT_LT((observer.sums()[0].turned - turned[2]).norm(), 1e-14);
}

TEST(CycleObserver, FindsNoChangeInARestingSwimmer) {
  MadeUpMotion motion;
  const auto change_of = [&](double drift_cells_per_step, double turn_rad_per_step) {
    motion.drift_cells_per_step = drift_cells_per_step;
    motion.turn_rad_per_step = turn_rad_per_step;
    CycleObserver observer(groups_of(case_of(three_spheres())));
    play(observer, motion, constant_forces(0, 0, 0), 3 * period + 1);
    const CycleSums& sums = observer.sums()[0];
    return change(sums.before_last, sums.last, observer.groups()[0].length_m);
  };
  const double lengths = 40.0 / period;  // per cycle
  EXPECT_FALSE(change_of(0.9e-9 * lengths, 0.0).velocity);
  EXPECT_TRUE(change_of(1.1e-9 * lengths, 0.0).velocity);
  EXPECT_FALSE(change_of(1e-4, 0.9e-9 / period).rotation);
  EXPECT_TRUE(change_of(1e-4, 1.1e-9 / period).rotation);
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
    second.restore(first.sums(), cut, 0);
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
  EXPECT_THROW(other.restore(one.sums(), 10, 0), StorageError);
  EXPECT_THROW(other.restore({}, 10, 0), StorageError);
  EXPECT_THROW(one.restore(one.sums(), 11, 0), StorageError);
  EXPECT_NO_THROW(one.restore(one.sums(), 10, 0));
}

}  // namespace
}  // namespace copepod::coupler
