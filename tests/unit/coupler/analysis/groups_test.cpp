#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "analysis/cycle_observer.hpp"
#include "analysis/made_up_motion.hpp"
#include "analysis/swimmer_figures.hpp"

namespace copepod::coupler {
namespace {

TEST(Groups, HaveTheCommonPeriodOfTheirDrivesOrTheLongest) {
  Swimmer swimmer = three_spheres();
  const auto measured = [&](std::int64_t first_steps, std::int64_t second_steps) {
    swimmer.arms[0].drive->signal.period_steps = first_steps;
    swimmer.arms[1].drive->signal.period_steps = second_steps;
    const Group group = groups_of(case_of(swimmer))[0];
    return std::pair(group.period_steps, group.note);
  };
  EXPECT_EQ(measured(period, period), std::pair(period, std::string()));
  EXPECT_EQ(measured(200, 300), std::pair(std::int64_t{600}, std::string("its drives have different periods; cycles "
                                                                         "are those of their common one, 600 steps")));
  EXPECT_EQ(measured(400, 200).first, 400);
  EXPECT_EQ(measured(100, 110).first, 1100);  // ten of the longest
  const auto [longest, note] = measured(100, 111);
  EXPECT_EQ(longest, 111);
  EXPECT_NE(note.find("no short common one; cycles are those of the longest, 111 steps"), std::string::npos) << note;
  EXPECT_EQ(measured(999'999'999'999'999, 1'000'000'000'000'000).first, 1'000'000'000'000'000);
}

TEST(Groups, HaveNoCyclesWithoutAPeriodicDrive) {
  Swimmer swimmer = three_spheres();
  for (Arm& arm : swimmer.arms) arm.drive.reset();
  const auto groups = groups_of(case_of(swimmer));
  EXPECT_EQ(groups[0].note, "without a periodic drive it has no cycles to measure");
  CycleObserver observer(groups);
  play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), 3 * period);
  EXPECT_TRUE(swimmer_reports(case_of(swimmer), observer)["swimmers"][0]["kinematics"]["cycle"].is_null());
}

TEST(Groups, AreAsLongAsTheirTwoOutermostSurfacesAreApart) {
  Case the_case;
  NamedGroup named{"all", {}, Eigen::Vector3d::UnitZ(), 0};
  std::srand(5);
  for (int i = 0; i < 60; ++i) {
    BodySpecification& body = the_case.bodies.emplace_back();
    body.name = std::to_string(i);
    body.position_m = Eigen::Vector3d::Random();
    body.shape = {i % 3 == 0 ? ShapeKind::capsule : ShapeKind::sphere, 0.01 * (1 + i % 7), i % 3 == 0 ? 0.2 : 0.0};
    named.bodies.push_back(body.name);
  }
  the_case.groups = {named};
  double longest_m = 0.0;
  for (const BodySpecification& one : the_case.bodies) {
    for (const BodySpecification& other : the_case.bodies) {
      const Eigen::Vector3d way_m = other.position_m - one.position_m;
      double length_m = way_m.norm();
      for (const Shape& shape : {one.shape, other.shape})  // capsules stand along z
        length_m += shape.radius_m + 0.5 * shape.length_m * std::abs(way_m.normalized().z());
      longest_m = std::max(longest_m, length_m);
    }
  }
  EXPECT_NEAR(groups_of(the_case)[0].length_m, longest_m, 1e-14);
}

TEST(Groups, MeasuresNamedGroupsOfBodiesLikeSwimmers) {
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
  EXPECT_TRUE(reports["groups"][0]["kinematics"].contains("u_GA_m_per_s"));
  EXPECT_FALSE(reports["groups"][1]["kinematics"].contains("u_GA_m_per_s"));  // of two bodies
  EXPECT_EQ(reports["groups"][3]["kinematics"]["cycle"], 0);
  EXPECT_FALSE(reports.contains("swarm"));
}

}  // namespace
}  // namespace copepod::coupler
