#include "run/program.hpp"

#include <csignal>

#include "config/yaml/keys.hpp"
#include "conversion/codec.hpp"
#include "run/program_fixture.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::json;

TEST_F(Program, RunsACaseAndLeavesACompleteRunDirectory) {
  EXPECT_EQ(run({"--log-file", (out_dir / "logs" / "coupler.log").string()}), 0) << out.str() << err.str();
  const json summary = file("summary.json");
  EXPECT_EQ(summary["case"], "small");
  EXPECT_EQ(summary["status"], "finished");
  EXPECT_EQ(summary["steps"], 2500);
  EXPECT_EQ(summary["digest"].get<std::string>().size(), 16U);
  EXPECT_DOUBLE_EQ(summary["timing"]["fluid_s"], 0.25 + 0.05);
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

TEST_F(Program, ShowsTheWaitForAFluidThatReportsNoPhases) {
  fluid_reports_phases = false;
  EXPECT_EQ(run(), 0) << out.str();
  const json timing = file("summary.json")["timing"];
  EXPECT_EQ(timing["fluid_s"], timing["exchange_wait_s"]);
  EXPECT_GT(timing["fluid_s"].get<double>(), 0.0);
  EXPECT_TRUE(timing["coupling_overhead"].is_null());
}

TEST_F(Program, TellsPhasesProgressAndTheEndAsJsonLines) {
  EXPECT_EQ(run(), 0);
  std::vector<std::string> phases;
  for (const json& event : events()) {
    if (event["event"] == "phase") phases.push_back(event["phase"]);
  }
  EXPECT_EQ(phases, (std::vector<std::string>{"starting", "handshake", "configuring", "running", "finishing"}));
  EXPECT_EQ(events().back()["event"], "finished");
  EXPECT_EQ(events().back()["summary"], (out_dir / "summary.json").string());
}

TEST_F(Program, GivesTheSameDigestForTheResolvedCase) {
  EXPECT_EQ(run(), 0);
  const json first = file("summary.json")["digest"];
  std::filesystem::copy_file(out_dir / "case.yaml", case_file, std::filesystem::copy_options::overwrite_existing);
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
      throw PeerFailed(
          {ExitCode::solver_failed, "fluid", "node7", 3, 1234, "cell (1, 2, 3) has no number (it diverged). Use trt."});
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

TEST_F(Program, EndsARunWhoseBodiesLeaveTheirPlaces) {
  EXPECT_EQ(run({"--set",
                 "actuators=[{kind: world_force, body: swimmer.B2, direction: [1, 0, 0], signal: {kind: constant, "
                 "amplitude_N: 1000, start_step: 700}}]"}),
            70);
  const json failure = events().back();
  EXPECT_EQ(failure["component"], "body");
  EXPECT_EQ(failure["step"], 700);
  const auto reason = failure["reason"].get<std::string>();
  EXPECT_NE(reason.find("In step 700 body 'swimmer.B2' moved by "), std::string::npos) << reason;
  EXPECT_NE(reason.find("more than its radius of 4 µm"), std::string::npos) << reason;
}

TEST_F(Program, RecordsInTheProvenanceWhatAComponentNeglects) {
  EXPECT_EQ(run({"--set", "fluid.solver=external", "--fluid", "another"}), 0) << out.str();
  json told = json::array();
  for (const json& event : events())
    if (event["event"] == "notice") told.push_back(event["text"]);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0], "ConstantDragFluid 1 neglects boundary:no_slip (the case uses it).");
  EXPECT_NE(told[1].get<std::string>().find("adds no lubrication"), std::string::npos);
  EXPECT_EQ(file("provenance.json")["notices"], told);
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
  EXPECT_EQ(events().back()["step"], -1);  // its reporter names none
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
  EXPECT_NE(events().back()["reason"].get<std::string>().find("integrator:semi_implicit_euler"), std::string::npos);
}

TEST_F(Program, RefusesBodiesWithoutSpringsBeforeTheFirstStep) {
  change_bodies = [](Capabilities& bodies) { bodies.features.erase("springs"); };
  before_exchange = [](std::int64_t) { ADD_FAILURE() << "a step was computed"; };
  EXPECT_EQ(run(), 65);
  EXPECT_NE(events().back()["reason"].get<std::string>().find("(springs)"), std::string::npos) << out.str();
  EXPECT_EQ(events().back()["step"], -1);
}

TEST_F(Program, DrivesBodiesWithoutPairForcesByWorldForcesAndSaysSo) {
  EXPECT_EQ(run(), 0);
  const double swum = file("summary.json")["swimmers"][0]["d1_cells"];
  std::filesystem::remove_all(out_dir);
  change_bodies = [](Capabilities& bodies) { bodies.features.erase("actuator:pair_force"); };
  EXPECT_EQ(run(), 0) << out.str();
  std::string told;
  for (const json& event : events()) told += event["event"] == "notice" ? event["text"] : "";
  EXPECT_NE(told.find("PointMassBodies 1 has no actuators that follow its bodies"), std::string::npos) << told;
  EXPECT_EQ(file("provenance.json")["notices"], json{told});
  EXPECT_NEAR(file("summary.json")["swimmers"][0]["d1_cells"].get<double>() / swum, 1.0, 1e-9) << "on a line";
}

TEST_F(Program, RefusesBodiesWithoutAnyActuators) {
  change_bodies = [](Capabilities& bodies) {
    bodies.features.erase("actuator:pair_force");
    bodies.features.erase("actuator:world_force");
  };
  EXPECT_EQ(run(), 65);
  EXPECT_NE(events().back()["reason"].get<std::string>().find("(actuator:pair_force)"), std::string::npos) << out.str();
}

TEST_F(Program, ReportsAFeatureThatDoesNotExistWithTheNearestOne) {
  change_bodies = [](Capabilities& bodies) { bodies.features.insert("springz"); };
  EXPECT_EQ(run(), 0);
  EXPECT_NE(out.str().find("announces 'springz' (not a known feature). Did you mean 'springs'?"), std::string::npos)
      << out.str();
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
  EXPECT_EQ(call({"--run", case_file, "--out", case_file + "/below", "--endpoint", "e", "--session", "s"}), 73);
  EXPECT_NE(err.str().find("cannot be created"), std::string::npos) << err.str();
}

TEST_F(Program, SaysThatTheLogCannotBeWritten) { EXPECT_EQ(run({"--log-file", "/proc/nothing/coupler.log"}), 73); }

TEST_F(Program, PlansACaseForTheDeployCommand) {
  EXPECT_EQ(
      call({"--plan", case_file, "--ranks", "3", "--fluid", "python3 'my fluid.py' --fast", "--set", "run.steps=900"}),
      0)
      << err.str();
  const json plan = json::parse(out.str());
  EXPECT_EQ(plan["name"], "small");
  EXPECT_EQ(plan["steps"], 900);
  EXPECT_EQ(plan["services"]["fluid"]["ranks"], 3);
  EXPECT_EQ(plan["services"]["fluid"]["command"], (json{"python3", "my fluid.py", "--fast"}));
  EXPECT_TRUE(plan["services"]["body"]["command"].is_null());
  EXPECT_EQ(
      plan["requires"]["fluid"],
      (json{{"solver:vacuum", {"neglects:solver", "neglects:solver:vacuum", "solver:external", "solver:vacuum"}}}));
  EXPECT_EQ(plan["case"]["run"]["steps"], 900);
  EXPECT_EQ(plan["warnings"].size(), 1U);  // 900 steps do not cover the stroke
  EXPECT_FALSE(plan["case_yaml"].get<std::string>().empty());
}

TEST_F(Program, PlansASweepWithWhatToSetForEachMember) {
  EXPECT_EQ(call({"--plan", case_file, "--set",
                  "sweep={combine: zip, parameters: {run.steps: [900, 1000], swimmers.0.name: ['007', b]}}"}),
            0)
      << err.str();
  const json sweep = json::parse(out.str())["sweep"];
  EXPECT_EQ(sweep["combine"], "zip");
  EXPECT_EQ(sweep["parameters"][0], (json{{"key", "run.steps"}, {"scale", "linear"}}));
  EXPECT_EQ(sweep["members"][0]["values"], (json{900, 7}));
  EXPECT_EQ(sweep["members"][0]["set"], (json{"run.steps=900", "swimmers.0.name=007", "sweep=null"}));
  EXPECT_EQ(sweep["members"][1]["set"][1], "swimmers.0.name=\"b\"");
}

TEST_F(Program, PlansACampaignWithSettingsForEveryCase) {
  EXPECT_EQ(call({"--plan", std::string(CONFIGS) + "/paper/campaign.yaml", "--set", "run.steps=900"}), 0) << err.str();
  const json plan = json::parse(out.str());
  EXPECT_EQ(plan["cases"].size(), 26U);
  EXPECT_EQ(plan["cases"][1]["set"], (json{"run.steps=900"}));
  EXPECT_EQ(
      call({"--run", std::string(CONFIGS) + "/paper/campaign.yaml", "--out", "o", "--endpoint", "e", "--session", "s"}),
      2);
}

std::string from_hex(const std::string& digits) {
  std::string bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2)
    bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  return bytes;
}

TEST_F(Program, PlansTheSetupsOfBothComponents) {
  EXPECT_EQ(call({"--plan", case_file, "--set", "fluid.solver=stokes", "--set", "fluid.density_kg_per_m3=1000", "--set",
                  "fluid.kinematic_viscosity_m2_per_s=1e-6"}),
            0)
      << err.str();
  const json setups = json::parse(out.str())["setups"];
  const FluidSetup fluid = conversion::fluid_setup_from_bytes(from_hex(setups["fluid"]));
  EXPECT_EQ(fluid.kind, FluidKind::stokes);
  EXPECT_EQ(fluid.bodies.size(), 3U);
  EXPECT_EQ(conversion::body_setup_from_bytes(from_hex(setups["body"])).springs.size(), 2U);
}

TEST_F(Program, EstimatesCellsAndItsOwnMemory) {
  EXPECT_EQ(call({"--plan", std::string(CONFIGS) + "/paper/design_a.yaml"}), 0) << err.str();
  const json plan = json::parse(out.str());
  EXPECT_EQ(plan["notes"][1]["what"], "relaxation time");
  EXPECT_EQ(plan["notes"][1]["value"], "0.6667");
  EXPECT_EQ(plan["estimate"]["cells"], 500000);
  EXPECT_EQ(plan["estimate"]["cell_updates"], 500000.0 * 196812);
  EXPECT_EQ(plan["estimate"]["memory_of"]["coupler_bytes"], std::int64_t{12} << 20);
}

TEST_F(Program, RejectsCommandLinesThatMakeNoSense) {
  EXPECT_EQ(call({}), 2);
  EXPECT_EQ(call({"--plan", case_file, "--run", case_file}), 2);
  EXPECT_EQ(call({"--run", case_file}), 2);
  EXPECT_EQ(call({"--walk", case_file}), 2);
  EXPECT_EQ(call({"--run", case_file, "--set", "sweep.parameters={run.steps: [1, 2]}", "--out", "o", "--endpoint", "e",
                  "--session", "s"}),
            2);
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
