#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/checks/checks.hpp"
#include "config/load_case.hpp"

namespace copepod::coupler {
namespace {

/// A ball of a tenth of the fluid's density in a lattice of 10 µm.
LoadedCase ball(const std::vector<std::string>& overrides) {
  const std::string text = R"(case: light
fluid:
  solver: lattice_boltzmann
  density_kg_per_m3: 1000
  kinematic_viscosity_m2_per_s: 1.0e-6
  cell_size_m: 1.0e-5
  relaxation_time: 0.6
  domain_cells: [40, 40, 40]
  collision: trt
bodies:
  - {name: ball, radius_m: 4.0e-5, mass_kg: 2.6808257e-11, position_m: [2.0e-4, 2.0e-4, 2.0e-4]}
run: {steps: 100}
)";
  return load_case_text(text, "light.yaml", overrides);
}

/// Its virtual mass, in displaced masses.
double of_ball(const std::vector<std::string>& overrides, std::vector<std::string>* warnings = nullptr) {
  const LoadedCase loaded = ball(overrides);
  if (warnings != nullptr) *warnings = loaded.warnings;
  constexpr double displaced_kg = 1000 * 4.0 / 3.0 * std::numbers::pi * 4.0e-5 * 4.0e-5 * 4.0e-5;
  return virtual_masses(loaded.content, loaded.assembly).mass_kg[0] / displaced_kg;
}

TEST(LightBodies, GetTheVirtualMassOfTheRule) {
  EXPECT_NEAR(of_ball({}), 1.5 / 4.0, 1e-9);
  EXPECT_NEAR(of_ball({"fluid.relaxation_time=0.51"}), (0.62 + 8.8 * 0.01) / 4.0, 1e-9);
  EXPECT_NEAR(of_ball({"fluid.collision=bgk", "fluid.moving_boundary=central_linear"}), 3.4 / 4.0, 1e-9);
  EXPECT_EQ(of_ball({"fluid.collision=bgk"}), of_ball({}));
  EXPECT_NEAR(of_ball({"fluid.relaxation_time=2.0"}), 1.2 / (4.0 * 1.5) + 21.0 * 1.5 / 16.0, 1e-9);
  EXPECT_NEAR(of_ball({"fluid.relaxation_time=2.2"}), 1.2 / (4.0 * 1.7) + 21.0 * 1.7 / 16.0, 1e-9);
  EXPECT_NEAR(of_ball({"fluid.relaxation_time=2.4", "bodies.0.mass_kg=2.68e-12"}),
              4.0 * (1.2 / (4.0 * 1.9) + 21.0 * 1.9 / 16.0), 1e-9);
  EXPECT_EQ(of_ball({"coupling.load_averaging=none"}), of_ball({}));
  EXPECT_NEAR(of_ball({"coupling.load_averaging=none", "fluid.moving_boundary=central_linear"}),
              1.2 / (4.0 * 0.1) + 21.0 * 0.1 / 16.0, 1e-9);
}

TEST(LightBodies, ReceiveTheLoadsAsTheyAreWhereTheseDoNotAlternate) {
  const auto averaging = [](const std::vector<std::string>& overrides) {
    const LoadedCase loaded = ball(overrides);
    return virtual_masses(loaded.content, loaded.assembly).averaging;
  };
  EXPECT_EQ(averaging({}), LoadAveraging::none);
  const std::string alternating = "fluid.moving_boundary=central_linear";
  EXPECT_EQ(averaging({alternating}), LoadAveraging::two_step);
  EXPECT_EQ(averaging({alternating, "fluid.relaxation_time=0.8"}), LoadAveraging::none);
  EXPECT_EQ(of_ball({alternating}), of_ball({}));
}

TEST(LightBodies, GetWhatTheCaseGives) {
  EXPECT_NEAR(of_ball({"coupling.virtual_mass=2.5"}), 2.5, 1e-12);
  EXPECT_NEAR(of_ball({"coupling.virtual_mass=2.5", "bodies.0.mass_kg=1.0e-8"}), 2.5, 1e-12);
  EXPECT_EQ(of_ball({"coupling.virtual_mass=none"}), 0.0);
  EXPECT_EQ(of_ball({"coupling.virtual_mass=auto"}), of_ball({}));
}

TEST(LightBodies, AreThoseThatTheCouplingWouldNotKeepStable) {
  // 1.4/r = 0.35 displaced masses of 2.68e-10 kg
  EXPECT_GT(of_ball({"bodies.0.mass_kg=9.3e-11"}), 0.0);
  EXPECT_EQ(of_ball({"bodies.0.mass_kg=9.5e-11"}), 0.0);
  // 1.65 τ^(3/2)/r = 1.17
  EXPECT_GT(of_ball({"fluid.relaxation_time=2", "bodies.0.mass_kg=3.1e-10"}), 0.0);
  EXPECT_EQ(of_ball({"fluid.relaxation_time=2", "bodies.0.mass_kg=3.2e-10"}), 0.0);
  // without averaging 2.8/(r (τ − 1/2)) = 7
  EXPECT_GT(of_ball({"coupling.load_averaging=none", "bodies.0.mass_kg=1.87e-9"}), 0.0);
  EXPECT_EQ(of_ball({"coupling.load_averaging=none", "bodies.0.mass_kg=1.88e-9"}), 0.0);
}

TEST(LightBodies, AreNotThoseWhoseMotionIsGiven) {
  for (const char* motion : {"fixed", "prescribed"}) {
    EXPECT_EQ(of_ball({std::string("bodies.0.motion=") + motion}), 0.0);
    EXPECT_EQ(of_ball({std::string("bodies.0.motion=") + motion, "coupling.virtual_mass=1"}), 0.0);
  }
  EXPECT_GT(of_ball({"bodies.0.motion=axis", "bodies.0.axis=[0, 0, 1]"}), 0.0);
}

TEST(LightBodies, NeedNoneInFluidsWithoutInertia) {
  EXPECT_EQ(of_ball({"fluid.solver=stokes"}), 0.0);
  EXPECT_EQ(of_ball({"fluid.solver=vacuum"}), 0.0);
  EXPECT_NEAR(of_ball({"fluid.solver=stokes", "coupling.virtual_mass=1"}), 1.0, 1e-12);
}

// Limits of stability: `tests/validation/load_response.py parabolic` and those of the other schemes.
TEST(LightBodies, AreWarnedOfWhereTheCaseLeavesThemUnstable) {
  const std::string ten_times_lighter = "bodies.0.mass_kg=2.68e-12";
  const std::string alternating = "fluid.moving_boundary=central_linear";
  const std::string rotation = "its rotation may diverge";
  struct {
    std::vector<std::string> overrides;
    std::string words;  ///< none: no warning of a light body
  } const cases[] = {
      {{}, ""},
      {{"coupling.virtual_mass=none"}, "0.1 times the mass of the fluid that it displaces"},
      {{"coupling.virtual_mass=none"}, "Use coupling.virtual_mass: auto"},
      {{"fluid.relaxation_time=0.55", "coupling.virtual_mass=0.75"}, "sound may drive it with more than 0.27"},
      {{"fluid.relaxation_time=0.52"}, ""},
      {{"fluid.collision=bgk", alternating, "fluid.relaxation_time=0.59"}, ""},
      {{"fluid.relaxation_time=2.0", "bodies.0.radius_m=3.0e-5", "bodies.0.mass_kg=1.2e-11"}, rotation},
      {{"fluid.relaxation_time=2.2", ten_times_lighter}, ""},
      {{"fluid.relaxation_time=2.4", ten_times_lighter}, ""},
      {{"fluid.relaxation_time=2.6", ten_times_lighter}, rotation},
      {{"fluid.relaxation_time=5.5", "bodies.0.radius_m=8.0e-5", "bodies.0.mass_kg=2.1e-11"}, rotation},
      {{"fluid.relaxation_time=5.5", "bodies.0.radius_m=8.0e-5", "bodies.0.mass_kg=1.1e-9"}, ""},
      {{alternating, "fluid.relaxation_time=0.8"}, "may oscillate from step to step). Use moving_boundary: parabolic"},
      {{"fluid.moving_boundary=interpolated", "coupling.load_averaging=none"}, "may oscillate from step to step"},
      {{"fluid.relaxation_time=0.8"}, ""}};
  for (const auto& [overrides, words] : cases) {
    std::vector<std::string> warnings;
    of_ball(overrides, &warnings);
    std::erase_if(warnings, [](const std::string& text) { return text.find("body 'ball'") == std::string::npos; });
    EXPECT_EQ(warnings.size(), words.empty() ? 0U : 1U) << testing::PrintToString(overrides);
    for (const std::string& text : warnings) EXPECT_NE(text.find(words), std::string::npos) << text;
  }
}

TEST(LightBodies, InStokesFlowHaveTheMassThatTheirDragAsksOfAStep) {
  const auto masses = [](const std::string& mass_kg, const std::string& virtual_mass) {
    const LoadedCase loaded =
        ball({"fluid={solver: stokes, density_kg_per_m3: 1000, kinematic_viscosity_m2_per_s: 1e-6, "
              "cell_size_m: 1e-5}",
              "step_s=1e-3", "bodies.0.mass_kg=" + mass_kg, "coupling.virtual_mass=" + virtual_mass});
    return virtual_masses(loaded.content, loaded.assembly);
  };
  const double drag_kg = 6.0 * std::numbers::pi * 1e-3 * 4.0e-5 * 1e-3;  // of a step
  const VirtualMasses light = masses("1e-10", "auto");
  EXPECT_NEAR(light.mass_kg[0], 10.0 / 3.0 * drag_kg - 1e-10, 1e-20);
  EXPECT_FALSE(light.returns);
  EXPECT_EQ(masses("2.6e-9", "auto").mass_kg[0], 0.0);
  EXPECT_TRUE(masses("2.6e-9", "none").returns);
  EXPECT_THROW(masses("1.2e-9", "none"), std::exception);
  EXPECT_TRUE(masses("1.2e-9", "1.0").returns);
}

// Results of the paper's cases keep their bits.
TEST(LightBodies, AreInNoneOfThePapersCases) {
  for (const char* folder : {"/paper", "/quick"}) {
    for (const auto& entry : std::filesystem::directory_iterator(std::string(CONFIGS) + folder)) {
      if (entry.path().filename() == "campaign.yaml") continue;
      const LoadedCase loaded = load_case(entry.path().string(), {});
      for (const double mass_kg : virtual_masses(loaded.content, loaded.assembly).mass_kg)
        EXPECT_EQ(mass_kg, 0.0) << entry;
    }
  }
}

}  // namespace
}  // namespace copepod::coupler
