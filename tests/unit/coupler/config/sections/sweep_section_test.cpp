#include <gtest/gtest.h>

#include "config/load_case.hpp"
#include "config/sections/sections.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

using Texts = std::vector<std::string>;

/// A small case; the sweep is in its last lines, from line 17 on.
std::string swept(const std::string& sweep) {
  return R"(case: swept
fluid: {solver: vacuum, cell_size_m: 1.0e-6}
step_s: 7.5e-10
swimmers:
  - name: swimmer
    center_m: [0, 0, 0]
    axis: [0, 0, 1]
    beads:
      - {shape: sphere, radius_m: 4.0e-6}
      - {shape: sphere, radius_m: 4.0e-6}
      - {shape: sphere, radius_m: 4.0e-6}
    bead_mass_kg: 5.44e-13
    rest_gap_m: [8.0e-6, 8.0e-6]
    spring: {stiffness_N_per_m: 1.7, damping_N_s_per_m: 1.6e-7}
    stroke: {amplitude_N: 1.0e-5, period_steps: 4000, phase_lag_steps: 1000, cycles: 1}
run: {steps: 4000}
)" + sweep;
}

std::vector<std::string> members_of(const std::string& text) {
  const std::optional<Sweep> sweep = read_sweep(Document::parse(text, "case.yaml", {}));
  std::vector<std::string> members;
  for (std::size_t member = 0; member < member_count(*sweep); ++member) members.push_back(member_text(*sweep, member));
  return members;
}

std::string problems_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    load_case_text(text, "case.yaml", overrides);
  } catch (const CaseInvalid& invalid) {
    return invalid.what();
  }
  return "";
}

void expect_in(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text << "\nlacks: " << part;
}

TEST(Range, HasNumbersAsAPersonWritesThem) {
  EXPECT_EQ(range_texts(0, 0.8, 9, SweepScale::linear),
            (Texts{"0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8"}));
  EXPECT_EQ(range_texts(-0.3, 0.3, 7, SweepScale::linear), (Texts{"-0.3", "-0.2", "-0.1", "0", "0.1", "0.2", "0.3"}));
  EXPECT_EQ(range_texts(100000, 500000, 3, SweepScale::linear), (Texts{"100000", "300000", "500000"}));
  EXPECT_EQ(range_texts(1e-6, 3e-6, 3, SweepScale::linear), (Texts{"1e-06", "2e-06", "3e-06"}));
  EXPECT_EQ(range_texts(1000000, 1000001, 4, SweepScale::linear),
            (Texts{"1000000", "1000000.3333", "1000000.6667", "1000001"}));
}

TEST(Range, HasShortValuesBetweenEndsAsTheyAreWritten) {
  EXPECT_EQ(range_texts(1e-6, 3e-6, 7, SweepScale::linear),
            (Texts{"1e-06", "1.3333e-06", "1.6667e-06", "2e-06", "2.3333e-06", "2.6667e-06", "3e-06"}));
  EXPECT_EQ(range_texts(1.23456789e-6, 8.7654321e-6, 3, SweepScale::logarithmic),
            (Texts{"1.23456789e-06", "3.29e-06", "8.7654321e-06"}));
}

TEST(Range, OfALogarithmicScaleHasConstantRatios) {
  EXPECT_EQ(range_texts(1e-6, 1e-2, 5, SweepScale::logarithmic), (Texts{"1e-06", "1e-05", "1e-04", "0.001", "0.01"}));
  EXPECT_EQ(range_texts(1, 10, 3, SweepScale::logarithmic), (Texts{"1", "3.162", "10"}));
  EXPECT_EQ(range_texts(-100, -1, 3, SweepScale::logarithmic), (Texts{"-100", "-10", "-1"}));
}

TEST(Sweep, OfSeveralKeysIsAGridWhoseLastKeyVariesFastest) {
  EXPECT_EQ(members_of(swept("sweep: {parameters: {run.steps: {from: 1, to: 2, count: 2}, "
                             "fluid.solver: [vacuum, stokes]}}\n")),
            (Texts{"steps=1, solver=\"vacuum\"", "steps=1, solver=\"stokes\"", "steps=2, solver=\"vacuum\"",
                   "steps=2, solver=\"stokes\""}));
}

TEST(Sweep, ZipsPairedLists) {
  EXPECT_EQ(members_of(swept("sweep: {parameters: {bodies.0.radius_m: [1, 1.0e-6], bodies.1.radius_m: [3, [4, 5]]}, "
                             "combine: zip}\n")),
            (Texts{"bodies.0.radius_m=1, bodies.1.radius_m=3", "bodies.0.radius_m=1e-06, bodies.1.radius_m=[4,5]"}));
}

TEST(Sweep, NamesBothLengthsOfListsThatAreNoPairs) {
  expect_in(problems_of(swept("sweep:\n  combine: zip\n  parameters:\n    run.steps: [1, 2]\n"
                              "    swimmers.0.phase_deg: {from: 0, to: 9, count: 4}\n")),
            "case.yaml:18: error: sweep.combine is zip, but run.steps has 2 values and swimmers.0.phase_deg "
            "has 4 (");
}

TEST(Sweep, IsReadAsItsFirstMember) {
  const LoadedCase loaded =
      load_case_text(swept("sweep: {parameters: {swimmers.swimmer.stroke.amplitude_N: [2.0e-5, 3.0e-5]}}\n"),
                     "case.yaml", {"swimmers.0.stroke.amplitude_N=5"});
  EXPECT_EQ(loaded.content.swimmers[0].three_beads->stroke.amplitude_N, 2.0e-5);
  EXPECT_TRUE(loaded.sweep);
}

TEST(Sweep, MayChooseTheParameterSet) {
  const std::string sets = "parameter_sets: {a: {run.steps: 4000}, b: {run.steps: 5000}}\nparameter_set: a\n";
  EXPECT_EQ(
      load_case_text(swept(sets + "sweep: {parameters: {parameter_set: [b, a]}}\n"), "case.yaml", {}).content.steps,
      5000);
}

TEST(Sweep, FindsATypoInASweptKeyOnceAndWhereItIsWritten) {
  EXPECT_EQ(
      problems_of(swept("sweep:\n  parameters:\n    swimmers.0.phase_deg: [0, 90]\n"
                        "    swimmers.0.stroke.amplitud_N: {from: 1.0e-5, to: 3.0e-5, count: 3}\n")),
      "case.yaml:20: error: key 'amplitud_N' is unknown (nothing in swimmers.0.stroke has this name). Did you mean "
      "amplitude_N?");
}

TEST(Sweep, NamesTheMembersThatCannotRun) {
  const std::string problems = problems_of(
      swept("sweep:\n  parameters:\n    swimmers.0.phase_deg: [0, 90]\n    swimmers.0.stroke.period_steps:\n"
            "      - 4000\n      - -4000\n"));
  expect_in(problems, "case.yaml:22: error: swimmers.0.stroke.period_steps is -4000 (");
  expect_in(problems, " [in member phase_deg=0, period_steps=-4000 and 1 other]");
  EXPECT_EQ(problems.find('\n'), std::string::npos) << problems;
}

TEST(Sweep, RefusesAnEnormousGridWithItsSize) {
  expect_in(problems_of(swept("sweep: {parameters: {run.steps: {from: 1, to: 1000, count: 1000}, "
                              "swimmers.0.phase_deg: {from: 0, to: 9, count: 1000}}}\n")),
            "sweep.parameters have 1e+06 combinations (1000 × 1000; at most 10000 are run).");
}

TEST(Sweep, RefusesToRunTheSameTwice) {
  expect_in(problems_of(swept("sweep: {parameters: {run.steps: [4000, 4000.0]}}\n")),
            "sweep.parameters have steps=4000 twice (");
}

TEST(Sweep, RefusesRangesThatAreNone) {
  const auto with_range = [](const std::string& range) {
    return problems_of(swept("sweep:\n  parameters:\n    swimmers.0.phase_deg: " + range + "\n"));
  };
  const std::string range = "case.yaml:19: error: sweep.parameters.swimmers.0.phase_deg";
  expect_in(with_range("{from: 1, to: 2, count: 1}"), range + ".count is 1 (a range has 2 to 10000");
  expect_in(with_range("{from: 1, to: 2, count: 1000000000000}"), range + ".count is 1000000000000 (");
  expect_in(with_range("{from: 1, to: 1, count: 3}"), range + ".to is 1 (so is `from`).");
  expect_in(with_range("{from: 1, count: 3}"), range + ".to is missing");
  expect_in(with_range("{from: -1, to: 1, count: 3, scale: logarithmic}"),
            range + ".scale is logarithmic (the range from -1 to 1 holds zero).");
  expect_in(with_range("{from: 1, to: 2, count: 3, scale: log}"), ".scale is 'log' (allowed: ");
  expect_in(with_range("{from: 1, to: 2, number: 3}"), "key 'number' is unknown");
  expect_in(with_range("[]"), range + " has no values (");
  expect_in(with_range("7"), range + " is not a list (");
}

TEST(Sweep, SaysWhatBecameOfTheFormOfOlderVersions) {
  expect_in(problems_of(swept("sweep: {key: run.steps, values: [1, 2]}\n")),
            "case.yaml:17: error: sweep.key and sweep.values have become sweep.parameters");
}

}  // namespace
}  // namespace copepod::coupler
