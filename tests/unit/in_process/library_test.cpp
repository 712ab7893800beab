#include <atomic>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <sys/file.h>
#include <thread>
#include <tuple>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "copepod.h"
#include "temporary_folder.hpp"

namespace copepod {
namespace {

namespace fs = std::filesystem;

constexpr const char* dumbbell = R"(
case: dumbbell
fluid: {solver: lattice_boltzmann, density_kg_per_m3: 1000, kinematic_viscosity_m2_per_s: 1.0e-6,
        domain_cells: [16, 12, 12], cell_size_m: 1.0e-6, boundaries: {x: periodic, y: periodic, z: periodic}}
step_s: 1.6e-7
bodies:
  - {name: left, radius_m: 2.0e-6, mass_kg: 6.0e-14, position_m: [4.3e-6, 6.1e-6, 6.2e-6]}
  - {name: right, radius_m: 2.0e-6, mass_kg: 6.0e-14, position_m: [11.2e-6, 6.1e-6, 6.2e-6]}
springs: [{bodies: [left, right], rest_length_m: 6.9e-6, stiffness_N_per_m: 1.0e-3}]
actuators:
  - {kind: pair_force, bodies: [left, right], signal: {kind: sinusoid, amplitude_N: 1.0e-10, period_steps: 40}}
  - {kind: rest_length, bodies: [left, right], signal: {kind: constant, amplitude_m: 0}}
run: {steps: 60}
output: {trajectory: {every_steps: 1}}
)";

class Library : public testing::Test {
 protected:
  Library() { std::ofstream(case_file_) << dumbbell; }

  int64_t open(std::vector<std::string> settings = {}, const fs::path& directory = {}) {
    std::vector<const char*> words;
    for (const std::string& setting : settings) words.push_back(setting.c_str());
    words.push_back(nullptr);
    int64_t handle = 0;
    const std::string folder = directory.string();
    EXPECT_EQ(copepod_open(case_file_.c_str(), words.data(), folder.empty() ? nullptr : folder.c_str(), &handle), 0)
        << copepod_error();
    return handle;
  }

  /// All numbers of both bodies.
  static std::vector<double> state(int64_t handle) {
    copepod_state now{};
    EXPECT_EQ(copepod_observe(handle, &now), 0) << copepod_error();
    std::vector<double> numbers;
    const auto add = [&](const double* values, int64_t each) {
      numbers.insert(numbers.end(), values, values + each * now.bodies);
    };
    add(now.orientation_wxyz, 4);
    for (const double* values :
         {now.position_m, now.velocity_m_per_s, now.angular_velocity_rad_per_s, now.force_N, now.torque_N_m})
      add(values, 3);
    return numbers;
  }

  static std::string digest(const fs::path& directory) {
    std::ifstream file(directory / "summary.json");
    return nlohmann::json::parse(file).at("digest");
  }

  TemporaryFolder folder_;
  std::string case_file_ = (folder_.path() / "case.yaml").string();
};

/// A text that is part of the last error of this thread.
testing::AssertionResult is_said(const std::string& part) {
  const std::string message = copepod_error();
  return message.find(part) == std::string::npos ? testing::AssertionFailure() << message : testing::AssertionSuccess();
}

TEST_F(Library, ReturnsToASnapshotBitByBitOnAnyNumberOfRanks) {
  const int64_t straight = open({}, folder_.path() / "straight");
  ASSERT_EQ(copepod_step(straight, 60, 0.0, nullptr), 0) << copepod_error();
  const std::vector<double> end = state(straight);
  ASSERT_EQ(copepod_close(straight), 0);

  for (const char* ranks : {"services.fluid.ranks=1", "services.fluid.ranks=3"}) {
    const fs::path directory = folder_.path() / ranks;
    const int64_t handle = open({ranks}, directory);
    int64_t snapshot = 0;
    ASSERT_EQ(copepod_step(handle, 23, 0.0, nullptr), 0);
    const std::vector<double> then = state(handle);
    ASSERT_EQ(copepod_snapshot(handle, &snapshot), 0) << copepod_error();
    for (int time = 0; time < 3; ++time) {
      ASSERT_EQ(copepod_act(handle, 0, 5e-10, 3), 0);
      ASSERT_EQ(copepod_step(handle, 9, 0.0, nullptr), 0);
      EXPECT_NE(state(handle), then);
      ASSERT_EQ(copepod_restore(handle, snapshot), 0) << copepod_error();
      EXPECT_EQ(state(handle), then);
    }
    ASSERT_EQ(copepod_drop(handle, snapshot), 0);
    ASSERT_EQ(copepod_step(handle, 37, 0.0, nullptr), 0);
    EXPECT_EQ(state(handle), end);
    ASSERT_EQ(copepod_close(handle), 0);
    EXPECT_EQ(digest(directory), digest(folder_.path() / "straight"));
  }
}

TEST_F(Library, SteersAsASignalOfTheCaseWould) {
  const std::vector<std::string> table{"actuators.0.signal={kind: table, times_steps: [0, 5], values: [0, 3.0e-10]}"};
  const std::vector<std::string> jump{"actuators.1.signal={kind: constant, amplitude_m: 2.0e-8}"};
  const std::vector<std::string> none;
  for (const auto& [actuator, value, steps, settings] :
       {std::tuple(0, 3e-10, 5, table), std::tuple(1, 2e-8, 0, jump), std::tuple(1, 0.0, 7, none)}) {
    const int64_t steered = open(), given = open(settings);
    ASSERT_EQ(copepod_act(steered, actuator, value, steps), 0) << copepod_error();
    for (const int64_t handle : {steered, given}) ASSERT_EQ(copepod_step(handle, 30, 0.0, nullptr), 0);
    EXPECT_EQ(state(steered), state(given)) << actuator;
    for (const int64_t handle : {steered, given}) ASSERT_EQ(copepod_close(handle), 0);
  }
}

TEST_F(Library, StartsARampWhereTheSignalIsThen) {
  const int64_t handle = open();
  ASSERT_EQ(copepod_act(handle, 0, 4e-10, 8), 0);
  ASSERT_EQ(copepod_step(handle, 4, 0.0, nullptr), 0);
  ASSERT_EQ(copepod_act(handle, 0, 4e-10, 4), 0);  // the same line, from half of it on
  ASSERT_EQ(copepod_step(handle, 10, 0.0, nullptr), 0);
  const int64_t other = open();
  ASSERT_EQ(copepod_act(other, 0, 4e-10, 8), 0);
  ASSERT_EQ(copepod_step(other, 14, 0.0, nullptr), 0);
  const std::vector<double> one = state(handle), two = state(other);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(one[i], two[i], 1e-12 * std::abs(two[i]) + 1e-30);
}

TEST_F(Library, RestoresWhatItsActuatorsWere) {
  const int64_t handle = open();
  ASSERT_EQ(copepod_act(handle, 0, 2e-10, 30), 0);
  ASSERT_EQ(copepod_step(handle, 10, 0.0, nullptr), 0);
  int64_t snapshot = 0;
  ASSERT_EQ(copepod_snapshot(handle, &snapshot), 0);
  ASSERT_EQ(copepod_step(handle, 10, 0.0, nullptr), 0);
  const std::vector<double> end = state(handle);
  ASSERT_EQ(copepod_act(handle, 0, -1e-10, 0), 0);
  ASSERT_EQ(copepod_restore(handle, snapshot), 0);
  ASSERT_EQ(copepod_step(handle, 10, 0.0, nullptr), 0);
  EXPECT_EQ(state(handle), end);
}

TEST_F(Library, StopsAStepWhenItsTimeIsUp) {
  const int64_t handle = open();
  int64_t done = -1;
  ASSERT_EQ(copepod_step(handle, 1'000'000, 0.02, &done), 0) << copepod_error();
  EXPECT_GE(done, 1);
  EXPECT_LT(done, 1'000'000);
  ASSERT_EQ(copepod_step(handle, std::numeric_limits<int64_t>::max(), 0.01, &done), 0) << copepod_error();
  EXPECT_GE(done, 1);
  ASSERT_EQ(copepod_step(handle, 0, 0.0, &done), 0);
  EXPECT_EQ(done, 0);
}

TEST_F(Library, ComesBackFromAFailureWithASnapshotOnly) {
  const fs::path directory = folder_.path() / "failed";
  const int64_t handle = open({}, directory);
  int64_t snapshot = 0;
  ASSERT_EQ(copepod_snapshot(handle, &snapshot), 0);
  const std::vector<double> start = state(handle);
  ASSERT_EQ(copepod_act(handle, 0, 1.0, 0), 0);  // a newton
  EXPECT_EQ(copepod_step(handle, 60, 0.0, nullptr), 70);
  EXPECT_TRUE(is_said("at step "));
  EXPECT_EQ(copepod_step(handle, 1, 0.0, nullptr), COPEPOD_MISUSE);
  EXPECT_TRUE(is_said("has failed"));
  int64_t other = 0;
  EXPECT_EQ(copepod_snapshot(handle, &other), COPEPOD_MISUSE);
  copepod_state now{};
  EXPECT_EQ(copepod_observe(handle, &now), COPEPOD_MISUSE);
  ASSERT_EQ(copepod_restore(handle, snapshot), 0) << copepod_error();
  EXPECT_EQ(state(handle), start);
  ASSERT_EQ(copepod_step(handle, 5, 0.0, nullptr), 0);
  ASSERT_EQ(copepod_act(handle, 0, 1.0, 0), 0);
  EXPECT_EQ(copepod_step(handle, 60, 0.0, nullptr), 70);
  ASSERT_EQ(copepod_close(handle), 0);
  EXPECT_FALSE(fs::exists(directory / "summary.json"));
  std::ifstream provenance(directory / "provenance.json");
  EXPECT_EQ(nlohmann::json::parse(provenance).at("exit_code"), 70);
}

TEST_F(Library, RefusesWhatMakesNoSense) {
  const int64_t handle = open();
  int64_t number = 0;
  const char* text = nullptr;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(copepod_open(nullptr, nullptr, nullptr, &number), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_open(case_file_.c_str(), nullptr, nullptr, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_describe(handle, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_cycles(handle, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_observe(handle, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_snapshot(handle, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_step(handle, -1, 0.0, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_step(handle, 1, -1.0, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_step(handle, 1, nan, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_act(handle, 2, 0.0, 0), COPEPOD_MISUSE);
  EXPECT_TRUE(is_said("the case has 2"));
  EXPECT_EQ(copepod_act(handle, -1, 0.0, 0), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_act(handle, 0, nan, 0), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_act(handle, 0, 0.0, -1), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_restore(handle, 7), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_drop(handle, 7), COPEPOD_MISUSE);
  ASSERT_EQ(copepod_close(handle), 0);
  EXPECT_EQ(copepod_close(handle), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_step(handle, 1, 0.0, nullptr), COPEPOD_MISUSE);
  EXPECT_EQ(copepod_describe(handle, &text), COPEPOD_MISUSE);
  EXPECT_TRUE(is_said("is not open"));
}

TEST_F(Library, RefusesACaseWithTheMessageOfTheCommand) {
  int64_t number = 0;
  const char* const bad[] = {"bodies.left.radius_m=-1", nullptr};
  EXPECT_EQ(copepod_open(case_file_.c_str(), bad, nullptr, &number), 2);
  EXPECT_TRUE(is_said("bodies.left.radius_m"));
  EXPECT_EQ(copepod_open("/does/not/exist.yaml", nullptr, nullptr, &number), 2);
  const char* const swept[] = {"sweep={parameters: {run.steps: [10, 20]}}", nullptr};
  EXPECT_EQ(copepod_open(case_file_.c_str(), swept, nullptr, &number), 2);
  EXPECT_TRUE(is_said("is a sweep"));
  const char* const traced[] = {"output.trace=true", nullptr};
  EXPECT_EQ(copepod_open(case_file_.c_str(), traced, nullptr, &number), 2);
  EXPECT_TRUE(is_said("output.trace"));
}

TEST_F(Library, OverwritesNoRun) {
  const fs::path directory = folder_.path() / "run";
  const int64_t handle = open({}, directory);
  ASSERT_EQ(copepod_step(handle, 20, 0.0, nullptr), 0);
  ASSERT_EQ(copepod_close(handle), 0);
  const std::string before = digest(directory);
  int64_t number = 0;
  EXPECT_EQ(copepod_open(case_file_.c_str(), nullptr, directory.c_str(), &number), 2);
  EXPECT_TRUE(is_said("holds a run"));
  EXPECT_EQ(digest(directory), before);
}

TEST_F(Library, ClosesWhateverTheDiskDoesAndReportsIt) {
  const fs::path directory = folder_.path() / "full";
  const int64_t handle = open({}, directory);
  ASSERT_EQ(copepod_step(handle, 5, 0.0, nullptr), 0);
  fs::create_directory(directory / "summary.json");  // where a file is to be
  EXPECT_EQ(copepod_close(handle), 73);
  std::ifstream provenance(directory / "provenance.json");
  EXPECT_EQ(nlohmann::json::parse(provenance).at("exit_code"), 73);
  EXPECT_EQ(copepod_close(handle), COPEPOD_MISUSE);
}

TEST_F(Library, LeavesNothingInMemory) {
  const std::string own = "copepod-simulation-" + std::to_string(getpid());
  const auto left = [&] {
    int folders = 0;
    for (const auto& entry : fs::directory_iterator("/dev/shm"))
      folders += static_cast<int>(entry.path().filename().string().starts_with(own));
    return folders;
  };
  const int before = left();
  const int64_t handle = open();
  for (int cycle = 0; cycle < 50; ++cycle) {
    int64_t snapshot = 0;
    ASSERT_EQ(copepod_snapshot(handle, &snapshot), 0);
    ASSERT_EQ(copepod_restore(handle, snapshot), 0);
    ASSERT_EQ(copepod_drop(handle, snapshot), 0);
  }
  EXPECT_EQ(left(), before + 1);  // the run directory that it has while it is open
  int64_t kept = 0;
  ASSERT_EQ(copepod_snapshot(handle, &kept), 0);
  ASSERT_EQ(copepod_close(handle), 0);
  EXPECT_EQ(left(), before);
}

TEST_F(Library, WritesNothingOnTheWayWithoutADirectory) {
  const auto written_bytes = [](int64_t handle, const fs::path& parent, const std::string& name) {
    EXPECT_EQ(copepod_step(handle, 60, 0.0, nullptr), 0) << copepod_error();
    std::uintmax_t bytes = 0;
    for (const auto& folder : fs::directory_iterator(parent)) {
      if (!folder.path().filename().string().starts_with(name)) continue;
      for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename() != "fluid.h5")  // a snapshot of another test
          bytes += entry.file_size();
    }
    EXPECT_EQ(copepod_close(handle), 0);
    return bytes;
  };
  const std::vector<std::string> much{"output.bodies={every_steps: 1}", "output.fields={every_steps: 1}"};
  const fs::path memory = "/dev/shm";
  const std::string own = "copepod-simulation-" + std::to_string(getpid());
  EXPECT_LT(written_bytes(open(much), memory, own), 50'000U);
  EXPECT_GT(written_bytes(open(much, folder_.path() / "kept"), folder_.path(), "kept"), 500'000U);
}

TEST_F(Library, RemovesWhatKilledProcessesLeftAndNothingElse) {
  const auto folder_with_file = [](const std::string& name) {
    const fs::path folder = fs::path("/dev/shm") / name;
    fs::create_directories(folder);
    std::ofstream(folder / "fluid.h5") << "populations";
    return folder;
  };
  const auto is_old = [](const fs::path& folder) {
    fs::last_write_time(folder, fs::file_time_type::clock::now() - std::chrono::hours(1));
  };
  const std::string number = std::to_string(getpid());
  const fs::path abandoned = folder_with_file("copepod-simulation-abandoned-" + number);
  const fs::path used = folder_with_file("copepod-simulation-used-" + number);
  const fs::path young = folder_with_file("copepod-simulation-young-" + number);
  const fs::path strange = folder_with_file("copepod-of-others-" + number);
  for (const fs::path& folder : {abandoned, used, strange}) is_old(folder);
  const int lock = ::open(used.c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(flock(lock, LOCK_EX), 0);
  ASSERT_EQ(copepod_close(open()), 0);
  EXPECT_FALSE(fs::exists(abandoned));
  for (const fs::path& folder : {used, young, strange}) {
    EXPECT_TRUE(fs::exists(folder / "fluid.h5")) << folder;
    fs::remove_all(folder);
  }
  ::close(lock);
}

TEST_F(Library, ServesThreadsWithASimulationEachAndRefusesASecondOneInTheSame) {
  const int64_t alone = open();
  ASSERT_EQ(copepod_step(alone, 40, 0.0, nullptr), 0);
  const std::vector<double> expected = state(alone);
  std::vector<std::thread> threads;
  std::vector<std::vector<double>> ends(3);
  for (std::vector<double>& end : ends)
    threads.emplace_back([&] {
      const int64_t own = open({"services.fluid.ranks=2"});
      for (int part = 0; part < 4; ++part) copepod_step(own, 10, 0.0, nullptr);
      end = state(own);
      copepod_close(own);
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& end : ends) EXPECT_EQ(end, expected);

  std::atomic<bool> is_on = true;
  std::thread first([&] {
    while (is_on) copepod_step(alone, 20, 0.0, nullptr);
  });
  int code = 0;
  while (code == 0) code = copepod_step(alone, 0, 0.0, nullptr);
  EXPECT_EQ(code, COPEPOD_MISUSE);
  EXPECT_TRUE(is_said("another thread"));
  is_on = false;
  first.join();
}

/// Calls in any order with any numbers end in a code, and those that are left work.
TEST_F(Library, SurvivesRandomCalls) {
  std::mt19937 choose(1);
  const auto any = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(choose); };
  std::vector<int64_t> handles{0, open()};
  for (int call = 0; call < 400; ++call) {
    const int64_t handle = handles[static_cast<std::size_t>(any(0, static_cast<int>(handles.size()) - 1))];
    int64_t number = 0;
    copepod_state now{};
    const char* text = nullptr;
    switch (any(0, 9)) {
      case 0:
        if (handles.size() < 5 && copepod_open(case_file_.c_str(), nullptr, nullptr, &number) == 0)
          handles.push_back(number);
        break;
      case 1:
        copepod_act(handle, any(-1, 2), any(-1, 1) * std::pow(10.0, any(-12, 3)), any(-1, 5));
        break;
      case 2:
        copepod_snapshot(handle, &number);
        break;
      case 3:
        copepod_restore(handle, any(0, 4));
        break;
      case 4:
        copepod_drop(handle, any(0, 4));
        break;
      case 5:
        if (any(0, 3) == 0) copepod_close(handle);
        break;
      case 6:
        copepod_observe(handle, &now);
        break;
      case 7:
        copepod_describe(handle, &text);
        break;
      case 8:
        copepod_cycles(handle, &text);
        break;
      default:
        copepod_step(handle, any(-1, 9), any(-1, 1) * 1e-3, &number);
    }
  }
  const int64_t fresh = open();
  EXPECT_EQ(copepod_step(fresh, 3, 0.0, nullptr), 0) << copepod_error();
  for (const int64_t handle : handles) copepod_close(handle);
}

}  // namespace
}  // namespace copepod
