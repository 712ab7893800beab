#include "run/program.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/command_words.hpp"
#include "fakes.hpp"
#include "run/signals.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::json;

std::string content_of(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// The coupler program with components in this process.
class Program : public testing::Test {
 protected:
  Program()
      : out_dir(std::filesystem::path(testing::TempDir()) /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(out_dir);
    case_file = out_dir.string() + ".yaml";
    std::ofstream(case_file) << R"(case: small
fluid: {solver: vacuum, cell_size_m: 1.0e-6}
step_s: 7.5e-10
swimmers:
  - name: swimmer
    center_m: [0, 0, 0]
    beads: [{radius_m: 4.0e-6}, {radius_m: 4.0e-6}, {radius_m: 4.0e-6}]
    bead_mass_kg: 5.44e-13
    rest_gap_m: [17.0e-6, 17.0e-6]
    spring: {stiffness_N_per_m: 100, damping_N_s_per_m: 1.0e-6}
    stroke: {amplitude_N: 5.0e-5, period_steps: 1000, phase_lag_steps: 250, cycles: 2}
run: {steps: 2500}
output: {trajectory: {every_steps: 100}}
)";
  }

  int call(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "coupler");
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    out.str("");
    err.str("");
    return run_program(static_cast<int>(argv.size()), argv.data(), out, err,
                       [&](const Options& options, const ServicesCase&) {
                         seen = options;
                         auto made = std::make_unique<LocalComponents>(drag, saves);
                         made->before_exchange = before_exchange;
                         made->on_connect = on_connect;
                         made->before_save = before_save;
                         components = made.get();
                         return std::unique_ptr<Components>(std::move(made));
                       });
  }
  int run(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"--run",      case_file, "--out",     out_dir.string(),
                                       "--endpoint", "none",    "--session", "secret-7"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  }
  [[nodiscard]] std::vector<json> events() const {
    std::vector<json> lines;
    std::istringstream text(out.str());
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
    return lines;
  }
  [[nodiscard]] json file(const char* name) const { return json::parse(content_of(out_dir / name)); }

  std::filesystem::path out_dir;
  std::string case_file;
  std::ostringstream out;
  std::ostringstream err;
  Options seen;
  double drag = 1e-6;
  bool saves = true;
  std::function<void(std::int64_t)> before_exchange;
  std::function<void()> on_connect, before_save;
  LocalComponents* components = nullptr;  ///< valid inside a run only
};

TEST_F(Program, RunsACaseAndLeavesACompleteRunDirectory) {
  EXPECT_EQ(run({"--log-file", (out_dir / "logs" / "coupler.log").string()}), 0) << out.str() << err.str();
  const json summary = file("summary.json");
  EXPECT_EQ(summary["case"], "small");
  EXPECT_EQ(summary["status"], "finished");
  EXPECT_EQ(summary["steps"], 2500);
  EXPECT_EQ(summary["digest"].get<std::string>().size(), 16U);
  EXPECT_EQ(summary["timing"]["fluid_s"], 0.25);
  EXPECT_EQ(summary["timing"]["body_s"], 0.01);
  for (const char* key : {"coupler_s", "exchange_wait_s", "coupling_overhead"})
    EXPECT_TRUE(summary["timing"].contains(key)) << key;
  EXPECT_TRUE(summary["swimmers"][0]["analysed"].get<bool>());
  EXPECT_GT(summary["swimmers"][0]["d1_cells"].get<double>(), 0.1);
  const json provenance = file("provenance.json");
  EXPECT_EQ(provenance["status"], "finished");
  EXPECT_EQ(provenance["exit_code"], 0);
  EXPECT_EQ(provenance["components"]["fluid"], "ConstantDragFluid 1");
  EXPECT_FALSE(provenance["end"].is_null());
  const auto command_line = provenance["command_line"].get<std::string>();
  EXPECT_NE(command_line.find("--session TOKEN"), std::string::npos) << command_line;
  EXPECT_NE(content_of(out_dir / "logs" / "coupler.log").find("running steps 0 to 2500"), std::string::npos);
  EXPECT_EQ(content_of(out_dir / "trajectory.csv").substr(0, 5), "step,");
  EXPECT_TRUE(std::filesystem::exists(out_dir / "case.yaml"));
}

TEST_F(Program, TellsPhasesProgressAndTheEndAsJsonLines) {
  EXPECT_EQ(run(), 0);
  std::vector<std::string> phases;
  for (const json& event : events()) {
    if (event["event"] == "phase") phases.push_back(event["phase"]);
  }
  EXPECT_EQ(phases,
            (std::vector<std::string>{"starting", "handshake", "configuring", "running", "finishing"}));
  EXPECT_EQ(events().back()["event"], "finished");
  EXPECT_EQ(events().back()["summary"], (out_dir / "summary.json").string());
}

TEST_F(Program, GivesTheSameDigestForTheResolvedCase) {
  EXPECT_EQ(run(), 0);
  const json first = file("summary.json")["digest"];
  std::filesystem::copy_file(out_dir / "case.yaml", case_file,
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_EQ(run(), 0);
  EXPECT_EQ(file("summary.json")["digest"], first);
}

TEST_F(Program, GivesAnotherDigestForAnotherMotion) {
  EXPECT_EQ(run(), 0);
  const json first = file("summary.json")["digest"];
  EXPECT_EQ(run({"--set", "swimmers.swimmer.stroke.amplitude_N=5.0000001e-5"}), 0);
  EXPECT_NE(file("summary.json")["digest"], first);
}

TEST_F(Program, ReportsWhichComponentFailedWhereAndWhen) {
  before_exchange = [](std::int64_t step) {
    if (step == 1234) {
      throw PeerFailed({ExitCode::solver_failed, "fluid", "node7", 3, 1234,
                        "cell (1, 2, 3) has no number (it diverged). Use trt."});
    }
  };
  EXPECT_EQ(run(), 70);
  const json failure = events().back();
  EXPECT_EQ(failure["event"], "failure");
  EXPECT_EQ(failure["code"], 70);
  EXPECT_EQ(failure["component"], "fluid");
  EXPECT_EQ(failure["host"], "node7");
  EXPECT_EQ(failure["rank"], 3);
  EXPECT_EQ(failure["step"], 1234);
  EXPECT_EQ(file("provenance.json")["exit_code"], 70);
  EXPECT_FALSE(std::filesystem::exists(out_dir / "summary.json"));
}

TEST_F(Program, NamesTheStepWhenAnErrorDoesNot) {
  before_exchange = [](std::int64_t step) {
    if (step == 77) throw ComponentLost("the fluid died (a test). Nothing to do.");
  };
  EXPECT_EQ(run(), 69);
  EXPECT_EQ(events().back()["step"], 76);  // the last step that the observers saw
}

TEST_F(Program, NamesTheComponentThatWasLost) {
  before_exchange = [](std::int64_t step) {
    if (step == 5)
      throw ComponentLost(
          FailureReport{ExitCode::component_lost, "body", "node2", 0, -1, "it died (a test). Nothing."});
  };
  EXPECT_EQ(run(), 69);
  EXPECT_EQ(events().back()["component"], "body");
  EXPECT_EQ(events().back()["host"], "node2");
  EXPECT_EQ(events().back()["step"], 4);
}

TEST_F(Program, TurnsAnUnexpectedExceptionIntoAReport) {
  before_exchange = [](std::int64_t) { throw std::runtime_error("surprise"); };
  EXPECT_EQ(run(), 70);
  EXPECT_NE(events().back()["reason"].get<std::string>().find("surprise"), std::string::npos);
}

TEST_F(Program, EndsWith143WhenSigtermAsksForIt) {
  before_exchange = [](std::int64_t step) {
    if (step == 10) std::raise(SIGTERM);
  };
  EXPECT_EQ(run(), 143);
  EXPECT_EQ(events().back()["code"], 143);
}

TEST_F(Program, EndsWith130WhenInterrupted) {
  before_exchange = [](std::int64_t step) {
    if (step == 10) std::raise(SIGINT);
  };
  EXPECT_EQ(run(), 130);
}

TEST_F(Program, RefusesACaseThatAComponentCannotDo) {
  EXPECT_EQ(run({"--set", "body.integrator=semi_implicit_euler"}), 65);
  EXPECT_NE(events().back()["reason"].get<std::string>().find("integrator:semi_implicit_euler"),
            std::string::npos);
}

TEST_F(Program, FailsBeforeTheFirstStepWhenNobodyConnects) {
  on_connect = [] { throw DeadlinePassed("the body service did not connect (60 s). Look at its log."); };
  EXPECT_EQ(run(), 74);
  EXPECT_EQ(events().back()["step"], -1);
}

TEST_F(Program, LeavesNoDirectoryBehindForABadCase) {
  EXPECT_EQ(run({"--set", "run.steps=-4"}), 2);
  EXPECT_NE(err.str().find("--set run.steps=-4: error: run.steps is -4"), std::string::npos) << err.str();
  EXPECT_FALSE(std::filesystem::exists(out_dir));
}

TEST_F(Program, SaysThatTheRunDirectoryCannotBeMade) {
  EXPECT_EQ(call({"--run", case_file, "--out", case_file + "/below", "--endpoint", "e", "--session", "s"}),
            73);
  EXPECT_NE(err.str().find("cannot be created"), std::string::npos) << err.str();
}

TEST_F(Program, SaysThatTheLogCannotBeWritten) {
  EXPECT_EQ(run({"--log-file", "/proc/nothing/coupler.log"}), 73);
}

const std::vector<std::string> checkpoints_every_700{"--set", "output.checkpoint.every_steps=700"};

TEST_F(Program, ResumesAfterACrashBitForBit) {
  EXPECT_EQ(run(checkpoints_every_700), 0) << out.str();
  const json undisturbed = file("summary.json");
  const std::string trajectory = content_of(out_dir / "trajectory.csv");
  for (const std::int64_t crash : {701L, 1399L, 1400L, 1401L, 2499L}) {
    std::filesystem::remove_all(out_dir);
    before_exchange = [crash](std::int64_t step) {
      if (step == crash) throw ComponentLost("the fluid died (a test). Nothing to do.");
    };
    EXPECT_EQ(run(checkpoints_every_700), 69);
    before_exchange = nullptr;
    std::vector<std::string> resume = checkpoints_every_700;
    resume.emplace_back("--resume");
    EXPECT_EQ(run(resume), 0) << out.str();
    const json resumed = file("summary.json");
    EXPECT_EQ(resumed["digest"], undisturbed["digest"]) << crash;
    EXPECT_EQ(resumed["swimmers"], undisturbed["swimmers"]) << crash;
    EXPECT_EQ(resumed["resumed_from_step"], crash / 700 * 700) << crash;
    EXPECT_EQ(content_of(out_dir / "trajectory.csv"), trajectory) << crash;
    EXPECT_EQ(file("provenance.json")["earlier_attempts"][0]["exit_code"], 69);
  }
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

TEST_F(Program, CannotResumeWithoutACheckpointOrWithThatOfAnotherCase) {
  EXPECT_EQ(run({"--resume"}), 73);
  EXPECT_EQ(run(checkpoints_every_700), 0);
  const std::string resolved_case = content_of(out_dir / "case.yaml");
  EXPECT_EQ(run({"--resume", "--set", "swimmers.0.stroke.amplitude_N=1.0e-5"}), 73);
  EXPECT_EQ(content_of(out_dir / "case.yaml"), resolved_case);
  EXPECT_NE(events().back()["reason"].get<std::string>().find("another case"), std::string::npos);
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
  EXPECT_NE(reason.find("Go on from its checkpoint with --resume"), std::string::npos) << reason;
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
  before_save = [] {
    std::raise(SIGTERM);
    std::raise(SIGTERM);
  };
  EXPECT_EQ(run(checkpoints_every_700), 143);
  EXPECT_EQ(process_signals().stop.load(), SIGTERM);  // every wait for a component ends with it
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
    EXPECT_NE(events().back()["reason"].get<std::string>().find("nothing is left to compute"),
              std::string::npos);
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

TEST_F(Program, PlansACaseForTheDeployCommand) {
  EXPECT_EQ(call({"--plan", case_file, "--ranks", "3", "--fluid", "python3 'my fluid.py' --fast", "--set",
                  "run.steps=900"}),
            0)
      << err.str();
  const json plan = json::parse(out.str());
  EXPECT_EQ(plan["name"], "small");
  EXPECT_EQ(plan["steps"], 900);
  EXPECT_EQ(plan["services"]["fluid"]["ranks"], 3);
  EXPECT_EQ(plan["services"]["fluid"]["command"], (json{"python3", "my fluid.py", "--fast"}));
  EXPECT_TRUE(plan["services"]["body"]["command"].is_null());
  EXPECT_EQ(plan["requires"]["fluid"], json{"solver:vacuum"});
  EXPECT_EQ(plan["case"]["run"]["steps"], 900);
  EXPECT_EQ(plan["warnings"].size(), 1U);  // 900 steps do not cover the stroke
  EXPECT_FALSE(plan["case_yaml"].get<std::string>().empty());
}

TEST_F(Program, EstimatesCellsAndMemoryOfALattice) {
  EXPECT_EQ(call({"--plan", std::string(CONFIGS) + "/paper/design_a.yaml"}), 0) << err.str();
  const json plan = json::parse(out.str());
  EXPECT_EQ(plan["estimate"]["cells"], 500000);
  // One set of populations, 4 bytes for the body of a cell, mean fields in three copies; processes and
  // padding.
  const double cells_bytes = 500000 * (19 * 4 + 4 + 3 * 36);
  EXPECT_GT(plan["estimate"]["memory_bytes"], cells_bytes);
  EXPECT_LT(plan["estimate"]["memory_bytes"], 1.5 * cells_bytes + 1e8);
  const json& memory = plan["estimate"]["memory_of"];
  EXPECT_EQ(memory["fluid_ranks"].get<int>() * memory["fluid_rank_bytes"].get<std::int64_t>() +
                memory["body_bytes"].get<std::int64_t>() + memory["coupler_bytes"].get<std::int64_t>(),
            plan["estimate"]["memory_bytes"].get<std::int64_t>());
  EXPECT_EQ(plan["estimate"]["cell_updates"], 500000.0 * 196812);
}

TEST_F(Program, RejectsCommandLinesThatMakeNoSense) {
  EXPECT_EQ(call({}), 2);
  EXPECT_EQ(call({"--plan", case_file, "--run", case_file}), 2);
  EXPECT_EQ(call({"--run", case_file}), 2);
  EXPECT_EQ(call({"--walk", case_file}), 2);
  EXPECT_EQ(call({"--plan", case_file, "--fluid", "'never closed"}), 2);
  EXPECT_EQ(call({"--plan", "/nonexistent/case.yaml"}), 2);
  EXPECT_EQ(call({"--version"}), 0);
}

TEST(SplitCommand, SplitsLikeAShell) {
  EXPECT_EQ(split_command("a  b\tc"), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(split_command(R"(python3 "my file.py" 'it''s' a\ b "" )"),
            (std::vector<std::string>{"python3", "my file.py", "its", "a b", ""}));
  EXPECT_TRUE(split_command("").empty());
}

}  // namespace
}  // namespace copepod::coupler
