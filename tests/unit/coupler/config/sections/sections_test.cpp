#include "config/sections/sections.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>

#include "config/load_case.hpp"
#include "config/yaml/document.hpp"

namespace copepod::coupler {
namespace {

std::string resolved_text(const Case& the_case) { return to_yaml(resolved(the_case)); }

std::vector<std::string> cases() {
  std::vector<std::string> files{std::string(CONFIG_TESTS) + "/every_key.yaml"};
  for (const char* folder : {"quick", "paper", "validation", "examples"}) {
    for (const auto& entry : std::filesystem::directory_iterator(std::string(CONFIGS) + "/" + folder)) {
      if (entry.path().extension() == ".yaml" && entry.path().filename() != "campaign.yaml")
        files.push_back(entry.path().string());
    }
  }
  return files;
}

TEST(ResolvedCase, ReadsBackToTheSameCaseBitForBit) {
  ASSERT_GE(cases().size(), 5U);
  for (const std::string& file : cases()) {
    const LoadedCase first = load_case(file, {});
    const std::string text = resolved_text(first.content);
    const LoadedCase second = load_case_text(text, "case.yaml", {});
    EXPECT_EQ(resolved_text(second.content), text) << file;
    EXPECT_EQ(first.content.step_s, second.content.step_s) << file;
    ASSERT_EQ(first.assembly.bodies.size(), second.assembly.bodies.size());
    for (std::size_t i = 0; i < first.assembly.bodies.size(); ++i) {
      EXPECT_EQ(first.assembly.bodies[i].position_m, second.assembly.bodies[i].position_m) << file;
      EXPECT_EQ(first.assembly.bodies[i].orientation_wxyz, second.assembly.bodies[i].orientation_wxyz) << file;
    }
  }
}

TEST(ResolvedCase, ReadsBackWithAnyAxis) {
  for (const char* axis : {"[1, 2, 3]", "[0.1, 0, -1]", "[0.001, 0.003, -1]", "[1.0e-7, 0, -1]", "[0, 0, -1]"}) {
    const LoadedCase first =
        load_case(std::string(CONFIGS) + "/quick/vacuum.yaml", {std::string("swimmers.0.axis=") + axis});
    EXPECT_NEAR(first.content.swimmers[0].orientation_wxyz.norm(), 1.0, 5e-16) << axis;
    const std::string text = resolved_text(first.content);
    EXPECT_EQ(resolved_text(load_case_text(text, "case.yaml", {}).content), text) << axis;
  }
}

// Bit for bit, so that the paper's designs keep their digests.
TEST(Arms, OfPerpendicularCapsulesHaveTheirGapAndTheRadii) {
  const LoadedCase loaded = load_case(std::string(CONFIGS) + "/paper/design_g.yaml", {});
  EXPECT_EQ(loaded.assembly.springs[0].rest_length_m, 12e-6 + 8e-6);
}

TEST(ResolvedCase, KeepsAnOverrideAfterAParameterSetWasChosen) {
  const std::string file = std::string(CONFIG_TESTS) + "/every_key.yaml";
  const LoadedCase first = load_case(file, {"swimmers.0.spring.stiffness_N_per_m=17.5", "parameter_set=soft"});
  EXPECT_EQ(first.content.swimmers[0].arms[0].stiffness_N_per_m, 17.5);
  const LoadedCase second = load_case_text(resolved_text(first.content), "case.yaml", {});
  EXPECT_EQ(second.content.swimmers[0].arms[0].stiffness_N_per_m, 17.5);
  EXPECT_EQ(second.content.parameter_set, "soft");
}

TEST(ResolvedCase, SpellsDefaultsOut) {
  const LoadedCase loaded = load_case(std::string(CONFIGS) + "/quick/vacuum.yaml", {});
  const auto json = resolved(loaded.content);
  EXPECT_EQ(json["coupling"]["load_averaging"], "two_step");
  EXPECT_EQ(json["body"]["integrator"], "runge_kutta_4");
  EXPECT_EQ(json["fluid"]["boundaries"]["z"]["high"], "no_slip");
  EXPECT_EQ(json["output"]["checkpoint"]["every_wall_s"], 600);
  EXPECT_EQ(json["run"]["steps"], 15000);
}

}  // namespace
}  // namespace copepod::coupler
