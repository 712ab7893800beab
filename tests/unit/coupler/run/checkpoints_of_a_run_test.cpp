#include <algorithm>
#include <csignal>
#include <map>

#include "checkpoint/checkpoint_store.hpp"
#include "run/program_fixture.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::json;

const std::vector<std::string> checkpoints_every_700{"--set", "output.checkpoint.every_steps=700"};

class CrashedProgram : public Program {
 protected:
  /// Of bodies.pvd and its frames, by name.
  [[nodiscard]] std::map<std::string, std::string> contents_of_bodies() const {
    std::map<std::string, std::string> contents{{"bodies.pvd", content_of(out_dir / "bodies.pvd")}};
    for (const auto& entry : std::filesystem::directory_iterator(out_dir / "bodies"))
      contents[entry.path().filename().string()] = content_of(entry.path());
    return contents;
  }
  /// @param settings  more of the command line
  void expect_the_same_after_crashes(std::vector<std::string> settings, const char* table = "trajectory.csv") {
    settings.insert(settings.end(), checkpoints_every_700.begin(), checkpoints_every_700.end());
    EXPECT_EQ(run(settings), 0) << out.str();
    const json undisturbed = file("summary.json");
    const std::string trajectory = content_of(out_dir / table);
    const std::string cycles = content_of(out_dir / "cycles.csv");
    const auto bodies = contents_of_bodies();
    EXPECT_EQ(bodies.size(), 27U) << "steps 0, 100, … 2500, and their list";
    EXPECT_EQ(std::count(cycles.begin(), cycles.end(), '\n'), 3);
    std::vector<std::string> resume = settings;
    resume.emplace_back("--resume");
    for (const std::int64_t crash : {701L, 1399L, 1400L, 1401L, 2499L}) {
      std::filesystem::remove_all(out_dir);
      before_exchange = [crash](std::int64_t step) {
        if (step == crash) throw ComponentLost("the fluid died (a test). Nothing to do.");
      };
      EXPECT_EQ(run(settings), 69);
      before_exchange = nullptr;
      EXPECT_EQ(run(resume), 0) << out.str();
      const json resumed = file("summary.json");
      EXPECT_EQ(resumed["digest"], undisturbed["digest"]) << crash;
      EXPECT_EQ(resumed["swimmers"], undisturbed["swimmers"]) << crash;
      EXPECT_EQ(resumed["resumed_from_step"], crash / 700 * 700) << crash;
      EXPECT_TRUE(content_of(out_dir / table) == trajectory) << crash;
      EXPECT_EQ(content_of(out_dir / "cycles.csv"), cycles) << crash;
      EXPECT_TRUE(contents_of_bodies() == bodies) << crash;
      EXPECT_EQ(file("provenance.json")["earlier_attempts"][0]["exit_code"], 69);
    }
  }
};

TEST_F(CrashedProgram, ResumesBitForBit) { expect_the_same_after_crashes({}); }

TEST_F(CrashedProgram, ResumesBitForBitWithATrajectoryAsAnArray) {
  expect_the_same_after_crashes({"--set", "output.trajectory.format=npy"}, "trajectory.npy");
  EXPECT_FALSE(std::filesystem::exists(out_dir / "trajectory.csv"));
}

TEST_F(CrashedProgram, ResumesBitForBitWithVirtualMasses) {
  expect_the_same_after_crashes({"--set",
                                 "fluid={solver: stokes, cell_size_m: 1.0e-6, density_kg_per_m3: 1360, "
                                 "kinematic_viscosity_m2_per_s: 7.36e-5}",
                                 "--set", "coupling.virtual_mass=1.5"});
}

TEST_F(Program, FallsBackToTheCheckpointBeforeADamagedOne) {
  EXPECT_EQ(run(checkpoints_every_700), 0);
  const json undisturbed = file("summary.json");
  std::filesystem::resize_file(out_dir / "checkpoints" / "step_000002100" / "body.bin", 10);
  EXPECT_EQ(run({"--set", "output.checkpoint.every_steps=700", "--resume"}), 0) << out.str();
  EXPECT_EQ(file("summary.json")["resumed_from_step"], 1400);
  EXPECT_EQ(file("summary.json")["digest"], undisturbed["digest"]);
  bool told = false;
  for (const json& event : events()) told = told || (event["event"] == "notice");
  EXPECT_TRUE(told);
}

TEST_F(Program, FallsBackToTheCheckpointWhoseRowsAreStillThere) {
  EXPECT_EQ(run(checkpoints_every_700), 0);
  const json undisturbed = file("summary.json");
  const std::string trajectory = content_of(out_dir / "trajectory.csv");
  std::filesystem::resize_file(out_dir / "trajectory.csv", trajectory.find("\n2000,"));
  EXPECT_EQ(run({"--resume"}), 0) << out.str();
  EXPECT_NE(out.str().find("trajectory.csv lacks rows that it had"), std::string::npos) << out.str();
  EXPECT_EQ(file("summary.json")["resumed_from_step"], 1400);
  EXPECT_EQ(file("summary.json")["digest"], undisturbed["digest"]);
  EXPECT_EQ(content_of(out_dir / "trajectory.csv"), trajectory);
}

TEST_F(Program, CannotResumeWithoutTheRowsThatTheRunHad) {
  for (const char* table : {"trajectory.csv", "cycles.csv"}) {
    std::filesystem::remove_all(out_dir);
    EXPECT_EQ(run(checkpoints_every_700), 0);
    std::filesystem::remove(out_dir / table);
    EXPECT_EQ(run({"--resume"}), 73) << table;
    const auto reason = events().back()["reason"].get<std::string>();
    EXPECT_NE(reason.find(std::string(table) + " lacks rows"), std::string::npos) << reason;
    EXPECT_FALSE(std::filesystem::exists(out_dir / table)) << "it must not be started anew";
  }
}

class ChangedCheckpoint : public Program {
 protected:
  void SetUp() override {
    EXPECT_EQ(run({"--set", "output.checkpoint.every_steps=700", "--set", "run.steps=2000"}), 0);
    state = json::parse(content_of(newest / "coupler.json"));
    key = json::parse(content_of(newest / "manifest.json"))["case"];
  }
  /// Exit code of a run that resumes the newest checkpoint with this state, whose checksums are right.
  int resume_with(const json& changed) {
    std::filesystem::remove(newest / "manifest.json");
    std::ofstream(newest / "coupler.json") << changed;
    write_manifest(newest, key, 1400);
    return run({"--resume"});
  }

  std::filesystem::path newest = out_dir / "checkpoints" / "step_000001400";
  json state;
  std::string key;  ///< of the case
};

TEST_F(ChangedCheckpoint, IsResumedIfNothingHasChanged) { EXPECT_EQ(resume_with(state), 0) << out.str(); }

TEST_F(ChangedCheckpoint, IsRefusedWithLoadsOfFewerBodies) {
  for (const char* part : {"force_N", "torque_N_m"}) {
    for (const std::size_t numbers : {0U, 3U, 6U}) {
      json changed = state;
      auto list = changed["previous_loads"][part].get<std::vector<double>>();
      list.resize(numbers);
      changed["previous_loads"][part] = list;
      EXPECT_EQ(resume_with(changed), 73) << part << ' ' << numbers;
    }
  }
  json none = state;
  none["previous_loads"]["force_N"] = none["previous_loads"]["torque_N_m"] = json::array();
  EXPECT_EQ(resume_with(none), 73);
  EXPECT_NE(events().back()["reason"].get<std::string>().find("loads are not those of all bodies"), std::string::npos);
}

TEST_F(ChangedCheckpoint, IsRefusedWithLoadsOfAnotherStepOrKinematicsThatTheCaseDoesNotNeed) {
  json changed = state;
  changed["previous_loads"]["step"] = 1;
  EXPECT_EQ(resume_with(changed), 73);
  changed = state;
  changed["previous_kinematics"]["position_m"] = {1.0, 2.0, 3.0};
  EXPECT_EQ(resume_with(changed), 73);
}

TEST_F(ChangedCheckpoint, IsRefusedWithAnotherCycleThanItsStepIsIn) {
  const json& sums = state["swimmers"][0];
  for (const char* number : {"number", "samples"}) {
    json changed = state;
    changed["swimmers"][0][number] = sums[number].get<int>() - 1;
    EXPECT_EQ(resume_with(changed), 73) << number;
  }
  json shorter = state;
  shorter["swimmers"][0]["last"]["arms"] = {1.0, 2.0, 3.0};
  EXPECT_EQ(resume_with(shorter), 73);
}

TEST_F(Program, CannotResumeWithoutACheckpoint) {
  EXPECT_EQ(run({"--resume"}), 2);
  EXPECT_NE(err.str().find("is not a run (it has no case.yaml)"), std::string::npos) << err.str();
  EXPECT_EQ(run(), 0);
  EXPECT_EQ(run({"--resume"}), 73);
}

TEST_F(Program, NamesTheKeysThatKeepACaseFromBeingResumed) {
  EXPECT_EQ(run(checkpoints_every_700), 0);
  const std::string resolved_case = content_of(out_dir / "case.yaml");
  EXPECT_EQ(run({"--resume", "--set", "swimmers.0.stroke.amplitude_N=1.0e-5"}), 2);
  EXPECT_EQ(content_of(out_dir / "case.yaml"), resolved_case);
  EXPECT_NE(err.str().find("another case (swimmers.0.stroke.amplitude_N is 1e-05, was "), std::string::npos)
      << err.str();
}

/// A second run, from the checkpoints of the first.
class BranchedProgram : public Program {
 protected:
  BranchedProgram() {
    EXPECT_EQ(run(checkpoints_every_700), 0);
    whole = file("summary.json");
    out_dir = folder.path("branch");
  }
  int branch(std::vector<std::string> settings) {
    settings.insert(settings.end(), {"--branch-from", first.string()});
    return run(settings);
  }

  std::filesystem::path first = out_dir;
  json whole;
};

TEST_F(BranchedProgram, EndsLikeTheFirstRunWithoutAChange) {
  EXPECT_EQ(branch({"--branch-step", "1400"}), 0) << out.str() << err.str();
  EXPECT_EQ(file("summary.json")["digest"], whole["digest"]);
  EXPECT_EQ(file("summary.json")["resumed_from_step"], 1400);
  EXPECT_EQ(file("provenance.json")["branched_from"],
            json({{"directory", first.string()}, {"step", 1400}, {"changed", json::object()}}));
}

TEST_F(BranchedProgram, GoesItsOwnWayWithAChangeThatItRecords) {
  EXPECT_EQ(branch({"--set", "swimmers.0.stroke.amplitude_N=1.0e-5"}), 0) << out.str() << err.str();
  EXPECT_NE(file("summary.json")["digest"], whole["digest"]);
  const json branched = file("provenance.json")["branched_from"];
  EXPECT_EQ(branched["step"], 2100);
  EXPECT_EQ(branched["changed"]["swimmers.0.stroke.amplitude_N"]["is"], "1e-05");
  EXPECT_EQ(content_of(out_dir / "trajectory.csv").find("\n0,"), std::string::npos);
  EXPECT_EQ(json::parse(content_of(first / "summary.json")), whole);
}

TEST_F(BranchedProgram, IsResumedFromACheckpointOfItsOwn) {
  const std::vector<std::string> settings{"--set", "swimmers.0.stroke.amplitude_N=1.0e-5", "--set",
                                          "output.checkpoint.every_steps=100"};
  EXPECT_EQ(branch(settings), 0) << out.str();
  const std::string digest = file("summary.json")["digest"];
  std::filesystem::remove_all(out_dir);
  before_exchange = [](std::int64_t step) {
    if (step == 2250) throw ComponentLost("the fluid died (a test). Nothing to do.");
  };
  EXPECT_EQ(branch(settings), 69);
  before_exchange = nullptr;
  std::vector<std::string> resumed = settings;
  resumed.emplace_back("--resume");
  EXPECT_EQ(run(resumed), 0) << out.str() << err.str();
  EXPECT_EQ(file("summary.json")["resumed_from_step"], 2200);
  EXPECT_EQ(file("provenance.json")["branched_from"]["directory"], first.string());
  EXPECT_EQ(file("summary.json")["digest"], digest);
}

TEST_F(BranchedProgram, AveragesNoFieldsOfTheOtherCase) {
  const auto changed = [this](const std::string& window) {
    return branch({"--set", "swimmers.0.stroke.amplitude_N=1.0e-5", "--set", "output.fields.mean_over_steps=" + window,
                   "--branch-step", "1400"});
  };
  EXPECT_EQ(changed("[1300, 2000]"), 2);
  const auto reason = events().back()["reason"].get<std::string>();
  EXPECT_NE(reason.find("mean_over_steps starts at 1300, before the branch at step 1400 (its samples so far are of "
                        "another case, swimmers.0.stroke.amplitude_N differs). Start it at 1400 or later."),
            std::string::npos)
      << reason;
  EXPECT_EQ(changed("[1400, 2000]"), 0) << out.str() << err.str();
  EXPECT_EQ(branch({"--set", "output.fields.mean_over_steps=[1300, 2000]", "--branch-step", "1400"}), 0) << err.str();
}

TEST_F(BranchedProgram, NeedsTheSameBodiesAndACheckpointThatIsThere) {
  EXPECT_EQ(branch({"--set", "swimmers.0.beads.0.radius_m=3.0e-6"}), 2);
  EXPECT_NE(err.str().find("the bodies or their shapes would change"), std::string::npos) << err.str();
  EXPECT_EQ(branch({"--set", "swimmers.0.center_m=[24.0e-6, 24.0e-6, 49.0e-6]"}), 2);
  EXPECT_NE(err.str().find("swimmers.0.center_m.0 is 2.4e-05, was 0.0: a branch begins with"), std::string::npos)
      << err.str();
  EXPECT_EQ(branch({"--branch-step", "1500"}), 73);
  const auto reason = events().back()["reason"].get<std::string>();
  EXPECT_NE(reason.find("no complete checkpoint of step 1500 (there is one of step 2100; there is one of step 1400)"),
            std::string::npos)
      << reason;
  EXPECT_EQ(run({"--branch-from", folder.path("nowhere")}), 2);
}

TEST_F(Program, ResumesWithTheComponentsThatWroteTheCheckpointOnly) {
  EXPECT_EQ(run(checkpoints_every_700), 0);
  change_bodies = [](Capabilities& bodies) { bodies.name = "Other Bodies"; };
  EXPECT_EQ(run({"--resume"}), 73);
  const auto reason = events().back()["reason"].get<std::string>();
  EXPECT_NE(reason.find("was written by the body component PointMassBodies, which is now Other Bodies"),
            std::string::npos)
      << reason;
  EXPECT_NE(reason.find("Resume with PointMassBodies, or start a new run"), std::string::npos) << reason;
}

TEST_F(Program, WritesACheckpointOnSigusr1AndGoesOn) {
  before_exchange = [](std::int64_t step) {
    if (step == 1000) std::raise(SIGUSR1);
  };
  EXPECT_EQ(run(), 0);
  EXPECT_TRUE(std::filesystem::exists(out_dir / "checkpoints" / "step_000001001" / "manifest.json"));
}

TEST_F(Program, WritesACheckpointBeforeItObeysSigterm) {
  before_exchange = [](std::int64_t step) {
    if (step == 1000) std::raise(SIGTERM);
  };
  EXPECT_EQ(run(), 143);
  EXPECT_EQ(events().back()["event"], "failure");
  EXPECT_TRUE(std::filesystem::exists(out_dir / "checkpoints" / "step_000001001" / "manifest.json"));
  before_exchange = nullptr;
  EXPECT_EQ(run({"--resume"}), 0);
  EXPECT_EQ(file("summary.json")["resumed_from_step"], 1001);
}

TEST_F(Program, TellsHowToGoOnFromTheCheckpointOfSigterm) {
  before_exchange = [](std::int64_t step) {
    if (step == 1000) std::raise(SIGTERM);
  };
  EXPECT_EQ(run(), 143);
  const auto reason = events().back()["reason"].get<std::string>();
  EXPECT_NE(reason.find("Continue from its checkpoint with --resume"), std::string::npos) << reason;
}

TEST_F(Program, ASignalDuringACheckpointGetsThatOne) {
  int saves_done = 0;
  before_save = [&saves_done] {
    ++saves_done;
    std::raise(SIGTERM);
  };
  EXPECT_EQ(run(checkpoints_every_700), 143);
  EXPECT_EQ(saves_done, 1);
  EXPECT_TRUE(std::filesystem::exists(out_dir / "checkpoints" / "step_000000700" / "manifest.json"));
}

TEST_F(Program, ASecondSigtermEndsACheckpointThatTakesTooLong) {
  before_exchange = [](std::int64_t step) {
    if (step == 1000) std::raise(SIGTERM);
  };
  int stop = 0;
  before_save = [&] {
    std::raise(SIGTERM);
    stop = signals->stop.load();
  };
  EXPECT_EQ(run(), 143);
  EXPECT_EQ(stop, SIGTERM);  // every wait for a component ends with it
}

TEST_F(Program, HasNothingToSaveBeforeTheFirstStep) {
  on_connect = [] { std::raise(SIGUSR1); };
  EXPECT_EQ(run(), 0) << out.str();
  EXPECT_FALSE(std::filesystem::exists(out_dir / "checkpoints" / "step_000000000"));
  EXPECT_TRUE(std::filesystem::exists(out_dir / "checkpoints" / "step_000000001"));
}

TEST_F(Program, SaysThatAResumedMeanFieldIsIncomplete) {
  const auto run_with_mean = [&](const char* steps, std::vector<std::string> more) {
    more.insert(more.end(), {"--set", std::string("output.fields.mean_over_steps=") + steps});
    return run(more);
  };
  const auto notices = [&] {
    std::string texts;
    for (const json& event : events()) texts += event["event"] == "notice" ? event["text"] : "";
    return texts;
  };
  EXPECT_EQ(run_with_mean("[100,2400]", checkpoints_every_700), 0) << err.str();
  EXPECT_EQ(run_with_mean("[100,2400]", {"--resume"}), 0);
  EXPECT_EQ(notices(), "");
  EXPECT_EQ(run_with_mean("[2200,2400]", {"--resume"}), 0);  // begins after the checkpoint
  EXPECT_EQ(notices(), "");
  EXPECT_EQ(run_with_mean("[200,2400]", {"--resume"}), 0);
  EXPECT_NE(notices().find("lacks its samples up to step 2100"), std::string::npos) << notices();
}

TEST_F(Program, RefusesToResumeBehindItsEndAndLosesNothing) {
  EXPECT_EQ(run(checkpoints_every_700), 0);
  const std::string trajectory = content_of(out_dir / "trajectory.csv");
  const std::string resolved_case = content_of(out_dir / "case.yaml");
  for (const char* steps : {"run.steps=1000", "run.steps=2100"}) {
    EXPECT_EQ(run({"--resume", "--set", steps}), 2) << out.str();
    EXPECT_NE(events().back()["reason"].get<std::string>().find("nothing is left to compute"), std::string::npos);
  }
  EXPECT_EQ(content_of(out_dir / "trajectory.csv"), trajectory);
  EXPECT_EQ(content_of(out_dir / "case.yaml"), resolved_case);
}

TEST_F(Program, StopsAtOnceWhenSigtermComesTwice) {
  before_exchange = [](std::int64_t step) {
    if (step != 1000) return;
    std::raise(SIGTERM);
    std::raise(SIGTERM);
  };
  EXPECT_EQ(run(), 143);
  EXPECT_FALSE(std::filesystem::exists(out_dir / "checkpoints" / "step_000001001"));
}

TEST_F(Program, GoesOnWhenTheDiskDoesNotTakeACheckpoint) {
  std::filesystem::create_directories(out_dir);
  std::ofstream(out_dir / "checkpoints") << "a file where the folder should be";
  EXPECT_EQ(run(checkpoints_every_700), 0) << out.str();
  std::size_t notices = 0;
  for (const json& event : events()) notices += event["event"] == "notice" ? 1 : 0;
  EXPECT_EQ(notices, 3U);
}

TEST_F(Program, WritesCheckpointsByTime) {
  EXPECT_EQ(run({"--set", "output.checkpoint.every_wall_s=1.0e-9", "--set", "run.steps=5"}), 0);
  EXPECT_TRUE(std::filesystem::exists(out_dir / "checkpoints" / "step_000000004"));
}

TEST_F(Program, DoesNotAskComponentsForCheckpointsThatTheyCannotWrite) {
  saves = false;
  EXPECT_EQ(run({"--set", "output.checkpoint.every_wall_s=1.0e-9", "--set", "run.steps=5"}), 0);
  EXPECT_FALSE(std::filesystem::exists(out_dir / "checkpoints"));
  EXPECT_EQ(run(checkpoints_every_700), 65);
}

}  // namespace
}  // namespace copepod::coupler
