#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/load_case.hpp"

namespace copepod::coupler {
namespace {

/// A case that runs but has something doubtful: overrides of the quick swimmer, the line, and words of
/// the warning.
struct Doubtful {
  std::string name;
  std::vector<std::string> overrides;
  std::string words;
};

const std::vector<Doubtful> doubtful_cases{
    {"bounce_back_of_a_body_that_moves_and_turns",
     {"bodies=[{name: top, radius_m: 4.0e-6, mass_kg: 4.0e-13, position_m: [12.0e-6, 12.0e-6, 12.0e-6], motion: "
      "prescribed, velocity_m_per_s: [3, 0, 0], angular_velocity_rad_per_s: [0, 0, 2.0e6]}]"},
     "leaves out the force ρ V Ω × U, here 0.09662 times its drag"},
    {"flow_statistics_of_no_sample",
     {"output.flow.every_steps=9000", "output.flow.from_step=9001"},
     "output.flow.from_step is after the last sample"},
    {"large_relaxation_time", {"fluid.relaxation_time=2.5", "fluid.collision=trt"}, "walls shift noticeably"},
    {"bgk_at_a_large_relaxation_time",
     {"fluid.relaxation_time=2"},
     "32 % error of the motion of a sphere of twice its density, radius 4 cells"},
    {"bgk_at_a_small_relaxation_time",
     {"fluid.relaxation_time=0.6", "fluid.moving_boundary=central_linear"},
     "5 % error of the motion of a sphere of twice its density, radius 4 cells"},
    {"interpolated_boundaries",
     {"fluid.relaxation_time=1.75", "fluid.collision=trt", "fluid.moving_boundary=interpolated"},
     "5 % error of the motion of a sphere of twice its density, radius 4 cells"},
    {"loads_of_a_turning_sphere",
     {"bodies=[{name: top, radius_m: 8.0e-6, mass_kg: 4.0e-12, position_m: [12.0e-6, 12.0e-6, 12.0e-6], motion: "
      "prescribed, angular_velocity_rad_per_s: [0, 0, 1]}]"},
     " % error of the loads on a turning sphere, radius 8 cells"},
    {"light_sphere_of_two_cells",
     {"bodies=[{name: ball, radius_m: 2.0e-6, mass_kg: 4.0e-16, position_m: [12.0e-6, 12.0e-6, 12.0e-6], motion: "
      "free}]",
      "fluid.relaxation_time=0.51", "fluid.collision=trt", "fluid.moving_boundary=parabolic"},
     "99 % or more error of the motion of a sphere of a hundredth of its density, radius 2 cells"},
    {"bead_close_to_a_wall",
     {"swimmers.0.center_m=[24.0e-6, 24.0e-6, 21.0e-6]", "swimmers.0.rest_gap_m=[8.5e-6, 8.0e-6]",
      "lubrication.cut_off_cells=none"},
     "less than one cell from the z face"},
    {"beads_close_together",
     {"swimmers.0.rest_gap_m=[0.5e-6, 8.0e-6]", "lubrication.cut_off_cells=none"},
     "less than one cell apart"},
    {"box_close_to_a_wall",
     {"bodies=[{name: dice, shape: box, edges_m: [8.0e-6, 8.0e-6, 8.0e-6], mass_kg: 7.0e-13, "
      "position_m: [9.0e-6, 9.0e-6, 4.5e-6]}]"},
     "Move it away: lubrication is of spheres with capsules or ellipsoids."},
    {"ellipsoid_close_to_a_capsule",
     {"bodies=[{name: egg, shape: ellipsoid, semi_axes_m: [4.0e-6, 4.0e-6, 5.0e-6], mass_kg: 4.6e-13, "
      "position_m: [9.0e-6, 9.0e-6, 12.0e-6]}, {name: rod, shape: capsule, radius_m: 4.0e-6, length_m: 8.0e-6, "
      "mass_kg: 9.0e-13, position_m: [17.5e-6, 9.0e-6, 12.0e-6]}]"},
     "use smaller cells: lubrication is of spheres with capsules or ellipsoids."},
    {"bead_of_a_cell", {"swimmers.0.beads.1.radius_m=1.0e-6"}, "a radius of 1 cells"},
    {"strong_stroke", {"swimmers.0.stroke.amplitude_N=2.0e-3", "fluid.collision=trt"}, "compressibility shows"},
    {"pressure_of_some_per_cent", {"fluid.boundaries={z: {high: {pressure_Pa: 5.0e7}}}"}, "volume fluxes will differ"},
    {"long_stroke", {"swimmers.0.stroke.amplitude_N=3.0e-4"}, "more than the gap between them"},
    {"short_run", {"run.steps=11000", "output.fields.mean_over_steps=[0, 0]"}, "Run longer for a result table"},
    {"mean_of_one_sample", {"output.fields.mean_every_steps=5000"}, "one sample in the whole window"},
    {"stokes_in_a_channel", {"fluid.solver=stokes"}, "ignores the domain's walls"},
    {"stokes_flow_between_beads_that_nearly_touch",
     {"fluid.solver=stokes", "swimmers.0.rest_gap_m=[1.0e-6, 8.0e-6]"},
     "starts 0.25 radii from 'swimmer.B2' (solver: stokes has no lubrication: the mobility towards it is about 69 %"},
    {"stokes_flow_close_to_its_plane",
     {"fluid.solver=stokes", "fluid.symmetry_planes=[]", "fluid.no_slip_plane=x_low",
      "swimmers.0.center_m=[5.0e-6, 24.0e-6, 48.0e-6]"},
     "starts 0.25 radii from the no-slip plane (solver: stokes has no lubrication: the mobility towards it is about "
     "62"},
    {"body_force_on_stokes_flow",
     {"fluid.solver=stokes", "fluid.no_slip_plane=x_low", "fluid.body_force_N_per_m3=[0, 0, 1]"},
     "fluid.body_force_N_per_m3 drives a flow"},
    {"vortex_of_low_viscosity",
     {"swimmers=[]", "fluid.symmetry_planes=[]", "fluid.boundaries={x: periodic, y: periodic}",
      "fluid.relaxation_time=0.51", "fluid.collision=trt",
      "fluid.initial_flow={kind: taylor_green, speed_m_per_s: 1100}"},
     "a Reynolds number of 14.95 per cell (with collision: trt or bgk flows diverge above about 10). Use collision"},
    {"stream_of_low_viscosity_at_its_fastest",
     {"swimmers=[]", "fluid.symmetry_planes=[]", "fluid.relaxation_time=0.51", "fluid.collision=trt",
      "fluid.boundaries={x: {low: {velocity_m_per_s: [110, 0, 0], signal: {kind: constant, amplitude: 10}}, high: "
      "outflow}}"},
     "a Reynolds number of 14.95 per cell (with collision: trt or bgk flows diverge above about 10). Use collision"},
    {"stokes_flow_that_does_not_start_at_rest",
     {"fluid.solver=stokes", "fluid.no_slip_plane=x_low",
      "fluid.initial_flow={kind: uniform, velocity_m_per_s: [0, 0, 1]}"},
     "fluid.initial_flow is a flow"},
    {"stokes_flow_that_starts_from_a_file",
     {"fluid.solver=stokes", "fluid.no_slip_plane=x_low", "fluid.initial_flow={kind: file, file: fields.h5}"},
     "fluid.initial_flow is a flow"},
    {"stokes_flow_beside_a_moving_wall",
     {"fluid.solver=stokes", "fluid.no_slip_plane=x_low", "fluid.boundaries={y: {velocity_m_per_s: [0, 0, 1]}}"},
     "fluid.boundaries.y.high drives a flow"},
    {"stokes_flow_in_a_periodic_channel",
     {"fluid.solver=stokes", "fluid.no_slip_plane=x_low", "fluid.boundaries={z: periodic}"},
     "fluid.boundaries.z is periodic"},
    {"body_force_on_the_fluid_alone",
     {"fluid.body_force_N_per_m3=[0, 0, 1.0e+3]"},
     "acts on the fluid alone (body 'swimmer.B2' lacks 2.681e-13 N"},
    {"body_force_beside_that_on_another_body",
     {"fluid.body_force_N_per_m3=[0, 0, 1.0e+3]",
      "actuators=[{kind: world_force, body: swimmer.B2, direction: [0, 0, 1], signal: {kind: constant, amplitude_N: "
      "2.681e-13}}]"},
     "acts on the fluid alone (body 'swimmer.B1' lacks 2.681e-13 N"},
    {"body_force_beside_half_of_it",
     {"fluid.body_force_N_per_m3=[0, 0, 1.0e+3]",
      "actuators=[{kind: world_force, body: swimmer.B2, direction: [0, 0, 1], signal: {kind: constant, amplitude_N: "
      "1.3405e-13}}]"},
     "acts on the fluid alone (body 'swimmer.B2' lacks 1.34e-13 N"},
    {"body_force_beside_a_periodic_one",
     {"fluid.body_force_N_per_m3=[0, 0, 1.0e+3]",
      "actuators=[{kind: world_force, body: swimmer.B2, direction: [0, 0, 1], signal: {kind: sinusoid, amplitude_N: "
      "2.681e-13, period_steps: 100}}]"},
     "acts on the fluid alone (body 'swimmer.B2' lacks 2.681e-13 N"},
    {"force_that_nothing_takes_up",
     {"fluid.symmetry_planes=[]", "fluid.boundaries={x: periodic, y: periodic, z: periodic}",
      "fluid.body_force_N_per_m3=[0, 0, 1.0e+6]"},
     "they accelerate for ever"},
    {"weight_that_nothing_takes_up",
     {"fluid.symmetry_planes=[]", "fluid.boundaries={x: periodic, y: free_slip, z: periodic}",
      "gravity_m_per_s2=[1.0e+7, 1.0e+9, 0]"},
     "they accelerate for ever"},
    {"mean_of_a_run_that_may_end_earlier",
     {"run.until_periodic={}"},
     "the run ends earlier if run.until_periodic is reached, and writes no mean then"},
    {"stroke_that_ends_before_its_run",
     {"run={steps: 30000, until_periodic: {}}"},
     "swimmers.0.stroke.cycles is 3 (the stroke ends before the run, which run.until_periodic can then no longer end)"},
    {"fields_of_a_vacuum", {"fluid.solver=vacuum"}, "output.fields asks for fields"},
    {"samples_of_a_vacuum",
     {"fluid.solver=vacuum", "output.flow={every_steps: 10}"},
     "output.flow asks for samples of the flow"},
    {"spring_almost_too_stiff", {"swimmers.0.spring.stiffness_N_per_m=2.0e6"}, "close to it oscillations"},
    {"stretched_spring",
     {"springs=[{bodies: [swimmer.B2, swimmer.B3], stiffness_N_per_m: 1, rest_length_m: 1.0e-6}]"},
     "a spring of rest length 1 µm starts at 32 µm (it will jerk its bodies)"},
    {"run_of_less_than_a_cycle",
     {"actuators=[{kind: world_force, body: swimmer.B1, direction: [0, 0, 1], signal: {kind: sinusoid, amplitude_N: "
      "1.0e-9, period_steps: 20000}}]"},
     "the period of actuators.0.signal 20000 (no whole cycle is measured)"},
    {"arms_side_by_side",
     {"swimmers=[{name: s, center_m: [24.0e-6, 24.0e-6, 48.0e-6], beads: [{name: A, radius_m: 4.0e-6, mass_kg: "
      "5.0e-13}, {name: B, radius_m: 4.0e-6, mass_kg: 5.0e-13}], arms: [{beads: [A, B], spring: {stiffness_N_per_m: 1, "
      "rest_gap_m: 8.0e-6}}, {beads: [B, A], spring: {stiffness_N_per_m: 1, rest_gap_m: 8.0e-6}}]}]"},
     "swimmers.0.arms.1 joins 'A' and 'B' like an arm before it"},
};

class DoubtfulCase : public testing::TestWithParam<Doubtful> {};

TEST_P(DoubtfulCase, IsAcceptedWithAWarning) {
  const LoadedCase loaded = load_case(std::string(CONFIGS) + "/quick/three_sphere.yaml", GetParam().overrides);
  bool found = false;
  for (const std::string& warning : loaded.warnings) {
    found = found ||
            (warning.find(": warning: ") != std::string::npos && warning.find(GetParam().words) != std::string::npos);
  }
  EXPECT_TRUE(found) << testing::PrintToString(loaded.warnings);
}

INSTANTIATE_TEST_SUITE_P(Config, DoubtfulCase, testing::ValuesIn(doubtful_cases),
                         [](const auto& instance) { return instance.param.name; });

/// The quick swimmer with a stiff spring whose rest length varies.
std::vector<std::string> warnings_of_rest_length(const std::string& amplitude_m) {
  return load_case(std::string(CONFIGS) + "/quick/three_sphere.yaml",
                   {"swimmers.0.spring.stiffness_N_per_m=4000",
                    "actuators=[{kind: rest_length, bodies: [swimmer.B2, swimmer.B1], signal: {kind: sinusoid, "
                    "amplitude_m: " +
                        amplitude_m + ", period_steps: 4000}}]"})
      .warnings;
}

TEST(DoubtfulCases, AreNotRestLengthsOfStiffSpringsThatVaryLittle) {
  EXPECT_TRUE(warnings_of_rest_length("7.9e-6").empty());
  const std::vector<std::string> warnings = warnings_of_rest_length("8.1e-6");
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("shortens by 8.1 µm, the gap between them is 8 µm (they could collide). Use a smaller "
                             "amplitude_m."),
            std::string::npos)
      << warnings[0];
}

TEST(DoubtfulCases, AreNotEllipsoidsWithThinFilms) {
  const LoadedCase loaded = load_case(
      CONFIGS "/quick/three_sphere.yaml",
      {"bodies=[{name: egg, shape: ellipsoid, semi_axes_m: [4.0e-6, 4.0e-6, 5.0e-6], mass_kg: 4.6e-13, position_m: "
       "[9.0e-6, 9.0e-6, 5.5e-6]}, {name: ball, radius_m: 4.0e-6, mass_kg: 3.6e-13, position_m: [17.5e-6, 9.0e-6, "
       "5.5e-6]}]"});
  for (const std::string& warning : loaded.warnings) EXPECT_EQ(warning.find("less than one cell"), std::string::npos);
}

TEST(DoubtfulCases, AreNotStrongForcesThatInertiaResists) {
  const auto warnings_of = [](const std::string& period_steps) {
    return load_case(std::string(CONFIGS) + "/quick/three_sphere.yaml",
                     {"actuators=[{kind: pair_force, bodies: [swimmer.B2, swimmer.B3], signal: {kind: sinusoid, "
                      "amplitude_N: 3.0e-3, period_steps: " +
                      period_steps + "}}]"})
        .warnings;
  };
  EXPECT_TRUE(warnings_of("100").empty());
  EXPECT_FALSE(warnings_of("4000").empty());
}

TEST(DoubtfulCases, AreNotLargeRelaxationTimesWithoutWalls) {
  const auto walls_are_warned_of = [](const std::string& faces) {
    const LoadedCase loaded = load_case(
        std::string(CONFIGS) + "/quick/three_sphere.yaml",
        {"fluid.relaxation_time=2.5", "fluid.collision=trt", "fluid.moving_boundary=parabolic",
         "fluid.symmetry_planes=[]", "fluid.boundaries={x: periodic, y: periodic, z: " + faces + "}", "swimmers=[]"});
    return std::ranges::any_of(loaded.warnings, [](const std::string& warning) {
      return warning.find("walls shift noticeably") != std::string::npos;
    });
  };
  EXPECT_TRUE(walls_are_warned_of("no_slip"));
  EXPECT_FALSE(walls_are_warned_of("periodic"));
}

TEST(DoubtfulCases, AreNotThoseOfOurConfigs) {
  int cases = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(CONFIGS)) {
    const std::string name = entry.path().filename().string();
    // A campaign is a list of cases; the runs of the resonance curve end within their stroke on purpose.
    if (entry.path().extension() != ".yaml" || name == "campaign.yaml" || name == "resonance.yaml") continue;
    EXPECT_TRUE(load_case(entry.path().string(), {}).warnings.empty()) << entry.path();
    ++cases;
  }
  EXPECT_GT(cases, 30);
}

}  // namespace
}  // namespace copepod::coupler
