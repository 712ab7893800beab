#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "analysis/made_up_motion.hpp"
#include "analysis/swimmer_figures.hpp"

namespace copepod::coupler {
namespace {

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
    observer.observe({step, state, none, none, constant_forces(0, 0, 0), none});
  }
  const auto report = swimmer_reports(case_of(swimmer), observer)["swimmers"][0];
  EXPECT_NEAR(report["u_swim_lattice"].get<double>(), 1e-4, 1e-12);
  EXPECT_NEAR(report["kinematics"]["u_along_cells_per_step"].get<double>(), 1e-4, 1e-12);
  EXPECT_NEAR(report["kinematics"]["u_along_um_per_s"].get<double>(), 1e6 * 1e-4 * cell_m / step_s, 1e-6);
  EXPECT_NEAR(report["kinematics"]["u_along_lengths_per_cycle"].get<double>(), 1e-4 * period / 40, 1e-12);
  EXPECT_NEAR(report["kinematics"]["u_GA_cells_per_step"].get<double>(), report["u_GA_lattice"].get<double>(), 1e-15);
  EXPECT_NEAR(report["kinematics"]["u_across_cells_per_step"].get<double>(), 0.0, 1e-16);
  EXPECT_NEAR(report["kinematics"]["Re"].get<double>(), report["Re_swim"].get<double>(), 1e-12);
  EXPECT_NEAR(report["kinematics"]["tilt_rad"].get<double>(), 0.0, 1e-12);
  EXPECT_EQ(report["kinematics"]["arms"][1]["bodies"][0], "swimmer.B1");
}

TEST(SwimmerReport, AveragesTheSpeedOverTheLastFiveCyclesButNotTheFirst) {
  Swimmer swimmer = three_spheres();
  swimmer.orientation_wxyz = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};  // z to −y
  for (Arm& arm : swimmer.arms) arm.drive->signal.stop_step = Signal::never;
  const auto kinematics_after = [&](std::int64_t cycles) {
    CycleObserver observer(groups_of(case_of(swimmer)));
    for (std::int64_t step = 0; step <= cycles * period; ++step) {
      Kinematics state = MadeUpMotion{}.at(step);
      const double time = static_cast<double>(step) / period;
      state.position_m.row(2).array() += 0.01 * cell_m * time * time;  // by 2k + 1 hundredths of a cell in cycle k
      const Eigen::Matrix3d turn = Eigen::AngleAxisd(pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
      state.position_m = (turn * state.position_m).eval();
      const Loads none = loads({0, 0, 0}, {0, 0, 0});
      observer.observe({step, state, none, none, none, none});
    }
    return swimmer_reports(case_of(swimmer), observer)["swimmers"][0]["kinematics"];
  };
  EXPECT_FALSE(kinematics_after(3).contains("u_along_mean_m_per_s"));  // two cycles after the first
  const auto four = kinematics_after(4), eight = kinematics_after(8);
  EXPECT_NEAR(four["u_along_mean_cells_per_step"].get<double>(), 1e-4 + 0.05 / period, 1e-12);
  EXPECT_NEAR(four["u_along_spread_cells_per_step"].get<double>(), 0.02 / period, 1e-12);
  EXPECT_NEAR(eight["u_along_mean_cells_per_step"].get<double>(), 1e-4 + 0.11 / period, 1e-12);
  EXPECT_NEAR(eight["u_along_spread_cells_per_step"].get<double>(), std::sqrt(10) * 0.01 / period, 1e-12);
}

TEST(SwimmerReport, CallsASwimmerAtRestThatNeitherMovesNorTurns) {
  const auto rests = [](double drift_cells_per_step, double turn_rad_per_step) {
    MadeUpMotion motion;
    motion.drift_cells_per_step = drift_cells_per_step;
    motion.turn_rad_per_step = turn_rad_per_step;
    motion.mean = motion.amplitude = {2, 2};  // at the ends of a cycle, the centroid is the middle bead
    motion.phase = {0, 0};
    CycleObserver observer(groups_of(case_of(three_spheres())));
    play(observer, motion, constant_forces(0, 0, 0), 3 * period + 1);
    return swimmer_reports(case_of(three_spheres()), observer)["swimmers"][0]["kinematics"]["at_rest"].get<bool>();
  };
  EXPECT_TRUE(rests(0.0, 0.0));
  EXPECT_FALSE(rests(1e-4, 0.0));
  EXPECT_FALSE(rests(0.0, 1e-4));
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
    if (step < 3 * period) observer.observe({step, both, none, none, none, none});
    if (step == 3 * period) observer.finish({step, both, none, none, none, none});
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
