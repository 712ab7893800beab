#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/load_case.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "geometry/rotation.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

/// Three balls of radius 1 in a row, 10 long.
const std::string row_of_balls =
    "template: {name: s, phase_deg: 30, beads: [{name: A, radius_m: 1, mass_kg: 1}, {name: B, radius_m: 1, mass_kg: "
    "1}, {name: C, radius_m: 1, mass_kg: 1}], arms: [{beads: [A, B], spring: {stiffness_N_per_m: 5, rest_gap_m: 2}, "
    "drive: {kind: pair_force, signal: {kind: sinusoid, amplitude_N: 0.1, period_steps: 400}}}, {beads: [B, C], "
    "spring: {stiffness_N_per_m: 5, rest_gap_m: 2}}]}";
const std::string whole_cube = "region_m: {x: [0, 100], y: [0, 100], z: [0, 100]}";

std::string swarm_text(const std::string& swarm, const std::string& more = "") {
  return "case: many\nfluid: {solver: vacuum}\nstep_s: 0.001\nswarm: {" + swarm + "}\n" + more + "run: {steps: 10}\n";
}

LoadedCase swarm_case(const std::string& swarm, const std::string& more = "") {
  return load_case_text(swarm_text(swarm, more), "many.yaml", {});
}

std::vector<std::string> swarm_errors(const std::string& text, const std::string& file = "many.yaml") {
  try {
    load_case_text(text, file, {});
  } catch (const CaseInvalid& invalid) {
    return invalid.lines();
  }
  return {};
}

TEST(SwarmSection, PlacesCopiesWithoutOverlap) {
  const LoadedCase loaded = swarm_case(row_of_balls + ", count: 120, minimal_gap_m: 1, " + whole_cube);
  ASSERT_EQ(loaded.content.swimmers.size(), 120U);
  EXPECT_EQ(loaded.content.swimmers[0].name, "s_001");
  EXPECT_EQ(loaded.content.swimmers[119].name, "s_120");
  EXPECT_EQ(loaded.content.swimmers[7].phase_deg, 30);
  const auto& bodies = loaded.assembly.bodies;
  ASSERT_EQ(bodies.size(), 360U);
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    EXPECT_GE(bodies[a].position_m.minCoeff(), 1.0);
    EXPECT_LE(bodies[a].position_m.maxCoeff(), 99.0);
    for (std::size_t b = 0; b < a; ++b) {
      if (a / 3 != b / 3) {
        EXPECT_GE((bodies[a].position_m - bodies[b].position_m).norm(), 3.0);
      }
    }
  }
}

TEST(SwarmSection, BecomesSwimmersOfTheResolvedCase) {
  const LoadedCase loaded = swarm_case(row_of_balls + ", count: 5, phases: random, " + whole_cube);
  const std::string text = to_yaml(resolved(loaded.content));
  EXPECT_EQ(text.find("swarm"), std::string::npos);
  const LoadedCase again = load_case_text(text, "case.yaml", {});
  EXPECT_EQ(to_yaml(resolved(again.content)), text);
  ASSERT_EQ(again.content.swimmers.size(), 5U);
  EXPECT_NE(again.content.swimmers[0].phase_deg, again.content.swimmers[1].phase_deg);
}

TEST(SwarmSection, FollowsItsSeedOnly) {
  const auto resolved_of = [](const std::string& keys) {
    return to_yaml(resolved(swarm_case(row_of_balls + ", count: 20, phases: random, " + whole_cube + keys).content));
  };
  EXPECT_EQ(resolved_of(""), resolved_of(", seed: 1"));
  EXPECT_NE(resolved_of(""), resolved_of(", seed: 2"));
}

TEST(SwarmSection, HasTheVolumeFractionThatIsAskedFor) {
  const LoadedCase loaded = swarm_case(row_of_balls + ", volume_fraction: 0.001, " + whole_cube);
  EXPECT_EQ(loaded.content.swimmers.size(), 80U);  // 1000 / (3 · 4π/3)
}

TEST(SwarmSection, AlignsCopiesWithinTheirSpread) {
  const std::string turned = ", count: 100, orientations: aligned, " + whole_cube;
  std::string along_x = row_of_balls;
  along_x.replace(along_x.find("phase_deg"), 0, "axis: [1, 0, 0], ");
  for (const Swimmer& swimmer : swarm_case(along_x + turned).content.swimmers)
    EXPECT_LT((z_axis(swimmer.orientation_wxyz) - Eigen::Vector3d::UnitX()).norm(), 1e-14);
  double least = 1.0;
  for (const Swimmer& swimmer : swarm_case(along_x + turned + ", spread_deg: 20").content.swimmers)
    least = std::min(least, z_axis(swimmer.orientation_wxyz).x());
  EXPECT_GE(least, std::cos(0.35));  // 20° are 0.349 rad
  EXPECT_LT(least, std::cos(0.30));
}

TEST(SwarmSection, KeepsOffWallsAndOtherBodiesAndCrossesPeriodicFaces) {
  const std::string text =
      "case: many\nfluid: {solver: lattice_boltzmann, density_kg_per_m3: 1, kinematic_viscosity_m2_per_s: 0.1, "
      "cell_size_m: 0.25, relaxation_time: 0.8, domain_cells: [80, 80, 80], boundaries: {x: no_slip, y: periodic, z: "
      "periodic}}\nbodies: [{name: ball, radius_m: 4, mass_kg: 300, position_m: [10, 10, 10]}]\n"
      "swarm: {" +
      row_of_balls + ", count: 60}\nrun: {steps: 10}\n";
  const LoadedCase loaded = load_case_text(text, "many.yaml", {});
  EXPECT_TRUE(loaded.warnings.empty() || loaded.warnings[0].find("less than one cell") == std::string::npos);
  int beyond = 0;
  for (std::size_t i = 0; i < 180; ++i) {
    const Eigen::Vector3d& place = loaded.assembly.bodies[i].position_m;
    EXPECT_GE(std::min(place.x(), 20.0 - place.x()), 1.25);
    EXPECT_GE((place - Eigen::Vector3d(10, 10, 10)).norm(), 5.25);
    if (std::min(place.y(), 20.0 - place.y()) < 1.0) ++beyond;
  }
  EXPECT_GT(beyond, 0);
}

TEST(SwarmSection, TakesPlacesAndAxesFromAFile) {
  const TemporaryFolder folder;
  std::ofstream(folder.path("places.csv")) << "x_m,y_m,z_m,axis_x,axis_y,axis_z\n50,50,20,0,3,0\n50,50,60,0,0,1\n";
  const LoadedCase loaded = load_case_text(
      swarm_text(row_of_balls + ", placement: file, file: places.csv, " + whole_cube), folder.path("many.yaml"), {});
  ASSERT_EQ(loaded.content.swimmers.size(), 2U);
  EXPECT_EQ(loaded.content.swimmers[0].name, "s_1");
  EXPECT_TRUE(loaded.assembly.bodies[0].position_m.isApprox(Eigen::Vector3d(50, 46, 20)));
  EXPECT_EQ(loaded.assembly.bodies[3].position_m, Eigen::Vector3d(50, 50, 56));
}

TEST(SwarmSection, NamesTheLinesOfPlacesThatOverlap) {
  const TemporaryFolder folder;
  std::ofstream(folder.path("places.csv")) << "x_m,y_m,z_m\n50,50,20\n\n20,20,20\n50,50.5,21\n1,50,96\n";
  const std::vector<std::string> errors = swarm_errors(
      swarm_text(row_of_balls + ", placement: file, file: places.csv, orientations: aligned, " + whole_cube),
      folder.path("many.yaml"));
  ASSERT_EQ(errors.size(), 2U) << testing::PrintToString(errors);
  EXPECT_NE(errors[0].find("places.csv:5: error: the swimmer and that of line 2 overlap by"), std::string::npos)
      << errors[0];
  EXPECT_NE(errors[1].find("places.csv:6: error: the swimmer reaches out of the region"), std::string::npos)
      << errors[1];
}

TEST(SwarmSection, PutsCopiesOnALattice) {
  const LoadedCase loaded = swarm_case(row_of_balls + ", placement: lattice, count: 64, " + whole_cube);
  EXPECT_EQ(loaded.content.swimmers[0].center_m, Eigen::Vector3d(12.5, 12.5, 12.5));
  EXPECT_EQ(loaded.content.swimmers[63].center_m, Eigen::Vector3d(87.5, 87.5, 87.5));
}

TEST(SwarmSection, ReportsOneErrorForEachMistake) {
  const std::string beads = row_of_balls + ", " + whole_cube;
  const std::vector<std::pair<std::string, std::string>> mistakes{
      {"count: 0, " + beads, "swarm.count is 0 (it must be positive)"},
      {"volume_fraction: 0, " + beads, "swarm.volume_fraction is 0 (it must be positive)"},
      {beads, "swarm.count is missing"},
      {"count: 5, volume_fraction: 0.1, " + beads, "swarm.volume_fraction is given together with count"},
      {"count: 5, " + row_of_balls + ", region_m: {x: [0, 100], y: [0, 100]}", "swarm.region_m.z is missing"},
      {"count: 5, " + row_of_balls + ", region_m: {x: [0, 100], y: [0, 100], z: [5, 5]}", "swarm.region_m.z is empty"},
      {"count: 5, " + whole_cube, "swarm.template is missing"},
      {"count: 5, center_m: [0, 0, 0], " + beads, "key 'center_m' is unknown"},
      {"count: 5, spread_deg: 5, " + beads, "swarm.spread_deg is given without orientations: aligned"},
      {"count: 5, orientations: aligned, spread_deg: 200, " + beads, "swarm.spread_deg is 200 (angles"},
      {"count: 5, file: places.csv, " + beads, "swarm.file is given without placement: file"},
      {"count: 5, file: places.csv, placement: file, " + beads, "swarm.count is given together with a file"},
      {"placement: file, " + beads, "swarm.file is missing"},
      {"placement: file, file: nowhere.csv, " + beads, "swarm.file is 'nowhere.csv'"},
      {"count: 1000000, " + beads, "swarm.count gives 1000000 swimmers (not even their largest beads have room"},
      {"count: 27, placement: lattice, minimal_gap_m: 30, " + beads, "swarm.placement is lattice (swimmer"},
      {"volume_fraction: 1.0e-7, " + beads, "swarm.volume_fraction is 1e-07 (0 swimmers"}};
  for (const auto& [swarm, expected] : mistakes) {
    const std::vector<std::string> errors = swarm_errors(swarm_text(swarm));
    const bool is_file_too = swarm.starts_with("count: 5, file: places.csv, placement");
    ASSERT_EQ(errors.size(), is_file_too ? 2U : 1U) << swarm << testing::PrintToString(errors);
    EXPECT_NE(errors[0].find(expected), std::string::npos) << errors[0];
  }
}

TEST(SwarmSection, SaysHowManyCouldBePlaced) {
  const std::vector<std::string> errors =
      swarm_errors(swarm_text("count: 500, " + row_of_balls + ", region_m: {x: [0, 20], y: [0, 20], z: [0, 20]}"));
  ASSERT_EQ(errors.size(), 1U);
  const std::string before = "swarm.count gives 500 swimmers (";
  const std::size_t place = errors[0].find(before);
  ASSERT_NE(place, std::string::npos) << errors[0];
  const int placed = std::stoi(errors[0].substr(place + before.size()));
  EXPECT_GT(placed, 50);
  EXPECT_LT(placed, 250);
}

TEST(SwarmSection, ReportsAMistakeOfTheTemplateOnce) {
  std::string thin = row_of_balls;
  thin.replace(thin.find("period_steps: 400"), 17, "period_steps: 3");
  const std::vector<std::string> errors = swarm_errors(swarm_text(thin + ", count: 40, " + whole_cube));
  ASSERT_EQ(errors.size(), 1U) << testing::PrintToString(errors);
  EXPECT_TRUE(errors[0].starts_with("many.yaml:4: error: swarm.template.arms.0")) << errors[0];
}

}  // namespace
}  // namespace copepod::coupler
