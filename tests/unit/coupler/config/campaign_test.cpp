#include <fstream>

#include <gtest/gtest.h>

#include "config/load_case.hpp"
#include "config/yaml/document.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

/// Reads a campaign that has been written to a file in `folder`.
Campaign load(const TemporaryFolder& folder, const std::string& text) {
  std::ofstream(folder.path("campaign.yaml")) << text;
  return load_campaign(folder.path("campaign.yaml"));
}

std::string problems_of(const std::string& text) {
  try {
    const TemporaryFolder folder;
    load(folder, text);
  } catch (const CaseInvalid& invalid) {
    return invalid.what();
  }
  return "";
}

TEST(Campaign, FindsItsCasesBesideItselfAndNamesThemAfterTheirFiles) {
  const TemporaryFolder folder;
  const Campaign campaign =
      load(folder,
           "campaign: two\njobs: 2\ncases:\n  - case: a.yaml\n"
           "  - {case: /elsewhere/a.yaml, name: b, set: {fluid.precision: double, fluid.symmetry_planes: [x]}}\n");
  EXPECT_EQ(campaign.name, "two");
  EXPECT_EQ(campaign.jobs, 2);
  ASSERT_EQ(campaign.cases.size(), 2U);
  EXPECT_EQ(campaign.cases[0].name, "a");
  EXPECT_EQ(campaign.cases[0].case_file, folder.path("a.yaml"));
  EXPECT_EQ(campaign.cases[1].name, "b");
  EXPECT_EQ(campaign.cases[1].case_file, "/elsewhere/a.yaml");
  const std::vector<std::string> settings{"fluid.precision=\"double\"", "fluid.symmetry_planes=[\"x\"]"};
  EXPECT_EQ(campaign.cases[1].settings, settings);
}

TEST(Campaign, RefusesTwoCasesOfOneName) {
  const std::string problems = problems_of("campaign: twins\ncases:\n  - case: a.yaml\n  - case: ../a.yaml\n");
  EXPECT_NE(problems.find("/campaign.yaml:4: error: cases.1 is called 'a' (so is cases.0)."), std::string::npos)
      << problems;
}

TEST(Campaign, RefusesNamesThatLeaveItsFolder) {
  EXPECT_NE(problems_of("campaign: c\ncases: [{case: a.yaml, name: ../a}]").find("Leave out slashes"),
            std::string::npos);
}

TEST(Campaign, RefusesNamesOfItsOwnFolders) {
  EXPECT_NE(problems_of("campaign: c\ncases: [{case: a.yaml, name: logs}]").find("'logs' (the campaign keeps"),
            std::string::npos);
  EXPECT_NE(problems_of("campaign: c\ncases: [{case: programs.yaml}]").find("Give it another `name`."),
            std::string::npos);
}

TEST(Campaign, OfThePaperRunsItsVacuumItsResonanceTheDragOfItsBeadsAndAllSeventeenDesigns) {
  EXPECT_EQ(load_campaign(std::string(CONFIGS) + "/paper/campaign.yaml").cases.size(), 26U);
}

TEST(Campaign, GivesSettingsOfTheCommandLineToEveryCaseAfterItsOwn) {
  const TemporaryFolder folder;
  std::ofstream(folder.path("c.yaml")) << "campaign: c\ncases: [{case: a.yaml, set: {run.steps: 1}}, {case: b.yaml}]\n";
  const std::vector<CampaignEntry> cases = load_campaign(folder.path("c.yaml"), {"run.steps=2"}).cases;
  EXPECT_EQ(cases[0].settings, (std::vector<std::string>{"run.steps=\"1\"", "run.steps=2"}));
  EXPECT_EQ(cases[1].settings, (std::vector<std::string>{"run.steps=2"}));
}

TEST(Campaign, IsToldFromACaseByItsName) {
  EXPECT_TRUE(names_campaign(std::string(CONFIGS) + "/paper/campaign.yaml"));
  EXPECT_FALSE(names_campaign(std::string(CONFIGS) + "/paper/vacuum.yaml"));
}

TEST(Campaign, RefusesToRunNothing) { EXPECT_NE(problems_of("campaign: c\n").find("has no cases"), std::string::npos); }

}  // namespace
}  // namespace copepod::coupler
