#include <gtest/gtest.h>

#include "coupled_run.hpp"
#include "fake_programs.hpp"
#include "run_keys.hpp"

namespace copepod::protocol_test {
namespace {

LinkSettings with(const RunKeys& keys) {
  LinkSettings settings;
  settings.key_file = keys.file_of("coupler");
  return settings;
}

Programs in_python() {
  setenv("PYTHONPATH", kPythonPath, 1);
  return {{kPython, std::string(kPythonExamples) + "stokes_drag_fluid.py"},
          {kPython, std::string(kPythonExamples) + "point_masses.py"}};
}

TEST(KeysOverTcp, RightOnesGiveTheDigestsOfARunWithoutWire) {
  const RunKeys keys;
  CoupledRun run(keys.option_of("fluid"), keys.option_of("body"), with(keys), tcp_endpoint());
  run.begin();
  run.advance(100);
  EXPECT_EQ(run.digests(), digests_of_local_run(100));
  run.link->finish();
  EXPECT_EQ(run.fluid_process->wait(), 0);
  EXPECT_EQ(run.body_process->wait(), 0);
}

TEST(KeysOverTcp, ComponentsInPythonUseThemToo) {
  const RunKeys keys;
  CoupledRun run(keys.option_of("fluid"), keys.option_of("body"), with(keys), tcp_endpoint(), in_python());
  run.begin();
  run.advance(10);
  run.link->finish();
  EXPECT_EQ(run.fluid_process->wait(), 0);
  EXPECT_EQ(run.body_process->wait(), 0);
}

TEST(KeysOverTcp, KeyOfTheBodyCannotSpeakAsTheFluid) {
  const RunKeys keys;
  CoupledRun run(keys.option_of("body"), keys.option_of("body"), with(keys), tcp_endpoint());
  try {
    run.link->await_components();
    FAIL() << "the body's key opened the fluid's door";
  } catch (const Refused& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("it holds the key of the body component"), std::string::npos)
        << refusal.what();
  }
  EXPECT_EQ(run.fluid_process->wait(), 65);
}

/// Without a key, or with one of another run, a component ends by itself, and never counts as connected.
class WrongKeys : public testing::TestWithParam<const char*> {};

TEST_P(WrongKeys, AreTurnedAway) {
  const RunKeys keys, others;
  const bool in_other_language = std::string(GetParam()).starts_with("Python");
  const bool has_key = std::string(GetParam()).ends_with("AnotherRun");
  std::atomic<int> stop{0};
  LinkSettings settings = with(keys);
  settings.stop_signal = [&] { return stop.load(); };
  CoupledRun run(has_key ? others.option_of("fluid") : std::vector<std::string>{}, keys.option_of("body"), settings,
                 tcp_endpoint(), in_other_language ? in_python() : Programs{});
  auto code = stop_after(*run.fluid_process, stop);
  EXPECT_THROW(run.link->await_components(), Interrupted);
  EXPECT_EQ(code.get(), 65);
  EXPECT_NE(run.fluid_log().find("turned this component away"), std::string::npos) << run.fluid_log();
}

INSTANTIATE_TEST_SUITE_P(Of, WrongKeys, testing::Values("NoKey", "AnotherRun", "PythonNoKey", "PythonAnotherRun"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(KeysOverTcp, AreAMustWhereOtherMachinesCanListen) {
  LinkSettings settings;
  settings.endpoint = "tcp://0.0.0.0:17613";
  EXPECT_THROW(Link link(settings), CaseError);
  ChildProcess fluid({kFakeFluid, "--endpoint", "tcp://10.0.0.1:17613", "--session", "secret"});
  EXPECT_EQ(fluid.wait(), 2);
  std::vector<std::string> words = in_python().body;
  for (const char* word : {"--endpoint", "tcp://10.0.0.1:17613", "--session", "secret"}) words.emplace_back(word);
  ChildProcess python(words);
  EXPECT_EQ(python.wait(), 2);
}

}  // namespace
}  // namespace copepod::protocol_test
