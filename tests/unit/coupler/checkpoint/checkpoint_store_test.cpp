#include "checkpoint/checkpoint_store.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "contract/errors.hpp"
#include "fakes.hpp"
#include "storage/table_file.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

namespace fs = std::filesystem;

CouplerState state_of(std::int64_t step) {
  CouplerState state;
  state.step = step;
  state.previous_loads.step = step - 1;
  state.previous_loads.force_N = Eigen::Matrix3Xd::Random(3, 2) / 3.0;
  state.previous_loads.torque_N_m = Eigen::Matrix3Xd::Random(3, 2) * 1e-300;
  state.previous_kinematics.step = step - 1;
  state.previous_kinematics.resize(2);
  state.previous_kinematics.position_m.setConstant(1.0 / 3.0);
  state.previous_kinematics.orientation_wxyz.setConstant(-1.0 / 7.0);
  state.previous_kinematics.velocity_m_per_s.setConstant(1e-300 / 3.0);
  state.previous_kinematics.angular_velocity_rad_per_s.setConstant(1e9 / 7.0);
  CycleSums sums;
  sums.number = 2;
  sums.first_position_m = Eigen::Matrix3Xd::Random(3, 4) / 7.0;
  sums.turned = Eigen::Matrix3d::Random() / 3.0;
  sums.arm_m = Eigen::Vector2d(1.0 / 3.0, -1e-17);
  sums.power_W = 0.1 + 0.2;
  sums.power_as_in_paper_W = 1.0 / 7.0;
  sums.samples = 12345;
  sums.last.number = 1;
  sums.last.translation_m = Eigen::Vector3d::Random() / 3.0;
  sums.last.arms = Eigen::Matrix3Xd::Random(3, 2);
  sums.latest_along_m = Eigen::Vector3d::Random() / 3.0;
  state.swimmers = {sums, CycleSums{}};
  state.balance.from_fluid_N_s = Eigen::Vector3d::Random() / 3.0;
  state.balance.from_drive_J = 1.0 / 7.0;
  state.loads = state.previous_loads;
  state.loads.flow = Eigen::VectorXd::Random(5) / 3.0;
  state.steered = {{}, {1.0 / 3.0, 2.0}};
  state.ways = {{7, 1.0 / 3.0, 1e-17}};
  return state;
}

class Store : public testing::Test {
 protected:
  void write(std::int64_t step) {
    store.prepare({{fluid_file, &fluid}, {body_file, &body}}, state_of(step));
    store.commit(step);
  }

  TemporaryFolder around;
  fs::path folder = around.path("checkpoints");
  CheckpointStore store{folder, "case one"};
  ConstantDragFluid fluid{1.0};
  PointMassBodies body{BodySetup{}};
};

TEST_F(Store, GivesBackEveryBitOfTheCouplersState) {
  const CouplerState state = state_of(1000);
  store.prepare({{fluid_file, &fluid}, {body_file, &body}}, state);
  store.commit(state.step);
  const CouplerState found = store.find().state;
  EXPECT_EQ(found.step, 1000);
  EXPECT_EQ(found.previous_loads.step, 999);
  EXPECT_EQ(found.previous_loads.force_N, state.previous_loads.force_N);
  EXPECT_EQ(found.previous_loads.torque_N_m, state.previous_loads.torque_N_m);
  EXPECT_EQ(found.previous_kinematics.step, 999);
  EXPECT_EQ(found.previous_kinematics.position_m, state.previous_kinematics.position_m);
  EXPECT_EQ(found.previous_kinematics.orientation_wxyz, state.previous_kinematics.orientation_wxyz);
  EXPECT_EQ(found.previous_kinematics.velocity_m_per_s, state.previous_kinematics.velocity_m_per_s);
  EXPECT_EQ(found.previous_kinematics.angular_velocity_rad_per_s, state.previous_kinematics.angular_velocity_rad_per_s);
  EXPECT_EQ(found.loads.force_N, state.loads.force_N);
  EXPECT_EQ(found.loads.torque_N_m, state.loads.torque_N_m);
  EXPECT_EQ(found.steered, state.steered);
  ASSERT_EQ(found.ways.size(), 1U);
  EXPECT_EQ(found.ways[0], state.ways[0]);
  ASSERT_EQ(found.swimmers.size(), 2U);
  EXPECT_EQ(found.swimmers[0].arm_m, state.swimmers[0].arm_m);
  EXPECT_EQ(found.swimmers[0].power_W, state.swimmers[0].power_W);
  EXPECT_EQ(found.swimmers[0].power_as_in_paper_W, state.swimmers[0].power_as_in_paper_W);
  EXPECT_EQ(found.swimmers[0].samples, 12345);
  EXPECT_EQ(found.balance.from_fluid_N_s, state.balance.from_fluid_N_s);
  EXPECT_EQ(found.balance.from_drive_J, state.balance.from_drive_J);
  EXPECT_EQ(found.swimmers[0].first_position_m, state.swimmers[0].first_position_m);
  EXPECT_EQ(found.swimmers[0].turned, state.swimmers[0].turned);
  EXPECT_EQ(found.swimmers[0].last.arms, state.swimmers[0].last.arms);
  EXPECT_EQ(found.swimmers[0].last.translation_m, state.swimmers[0].last.translation_m);
  EXPECT_FALSE(found.swimmers[1].power_as_in_paper_W);
  EXPECT_EQ(to_json(found), to_json(state));
}

TEST_F(Store, KeepsTheNewestTwoAndNothingUnfinished) {
  for (const std::int64_t step : {1000L, 2000L, 3000L, 1'000'000'000L}) write(step);
  EXPECT_FALSE(fs::exists(folder / "step_000001000"));
  EXPECT_FALSE(fs::exists(folder / "step_000002000"));
  EXPECT_TRUE(fs::exists(folder / "step_000003000" / "manifest.json"));
  EXPECT_TRUE(fs::exists(folder / "step_1000000000" / "fluid.h5"));
  EXPECT_FALSE(fs::exists(folder / "unfinished"));
  EXPECT_EQ(store.find().state.step, 1'000'000'000);
}

TEST_F(Store, CountsNoFileOfOthersAmongTheNewestTwo) {
  for (const std::int64_t step : {1000L, 2000L}) write(step);
  std::ofstream(folder / "step_000002500") << "notes";
  write(3000);
  EXPECT_TRUE(fs::exists(folder / "step_000002000" / "manifest.json"));
  EXPECT_TRUE(fs::exists(folder / "step_000002500"));
}

TEST_F(Store, KeepsNoneOfALaterStepWhichTheRunCouldNotUse) {
  for (const std::int64_t step : {1000L, 2000L}) write(step);
  fs::resize_file(folder / "step_000002000" / "body.bin", 3);
  EXPECT_EQ(store.find().state.step, 1000);
  write(1500);
  EXPECT_FALSE(fs::exists(folder / "step_000002000"));
  EXPECT_TRUE(fs::exists(folder / "step_000001000"));
  EXPECT_EQ(store.find().state.step, 1500);
}

TEST_F(Store, LeavesOrRefusesFoldersWithFilesOfOthers) {
  const auto put = [&](const std::string& name) {
    fs::create_directories(folder / name);
    std::ofstream(folder / name / "thesis.tex") << "work of a year";
  };
  put("step_000000500");
  put("step_000009000");  // later than the run: none of its own is kept there
  for (const std::int64_t step : {1000L, 2000L, 3000L}) write(step);
  fs::create_directory_symlink(folder / "step_000009000", folder / "step_000009001");
  write(4000);
  put("step_000005000");
  EXPECT_THROW(write(5000), StorageError);
  put("unfinished");
  EXPECT_THROW(write(6000), StorageError);
  for (const char* name : {"step_000000500", "step_000009000", "step_000005000", "unfinished"})
    EXPECT_TRUE(fs::exists(folder / name / "thesis.tex")) << name;
  EXPECT_TRUE(fs::is_symlink(folder / "step_000009001"));
}

TEST_F(Store, IgnoresACheckpointThatWasNotFinished) {
  write(1000);
  write(2000);
  fs::rename(folder / "step_000002000", folder / "unfinished");
  EXPECT_EQ(store.find().state.step, 1000);
}

TEST_F(Store, FindsEveryBitThatFlipsInAnyFile) {
  write(1000);
  write(2000);
  const fs::path newest = folder / "step_000002000";
  for (const char* name : {"fluid.h5", "body.bin", "coupler.json"}) {
    const std::string good = content_of(newest / name);
    ASSERT_FALSE(good.empty());
    for (std::size_t byte = 0; byte < good.size(); byte += 7) {
      std::string bad = good;
      bad[byte] = static_cast<char>(bad[byte] ^ (1 << (byte % 8)));
      std::ofstream(newest / name, std::ios::binary) << bad;
      const FoundCheckpoint found = store.find();
      EXPECT_EQ(found.state.step, 1000) << name << " byte " << byte;
      EXPECT_EQ(found.skipped.size(), 1U);
    }
    std::ofstream(newest / name, std::ios::binary) << good;
  }
  EXPECT_EQ(store.find().state.step, 2000);
}

TEST_F(Store, NeverUsesADamagedManifestForSomethingElse) {
  write(1000);
  write(2000);
  const fs::path manifest = folder / "step_000002000" / "manifest.json";
  const std::string good = content_of(manifest);
  for (std::size_t length = 0; length < good.size() - 1; length += 11) {
    std::ofstream(manifest, std::ios::binary) << good.substr(0, length);
    EXPECT_EQ(store.find().state.step, 1000) << length;
  }
}

TEST_F(Store, NeedsTheRowsThatTheTablesOfTheRunHad) {
  const fs::path table = around.path("trajectory.csv");
  std::ofstream(table) << "step,body\n0,a\n";
  const auto write_with_table = [&](std::int64_t step) {
    const std::uintmax_t bytes = fs::file_size(table);
    CouplerState state = state_of(step);
    state.tables["trajectory.csv"] = {bytes, checksum_of_start(table, bytes).value()};
    store.prepare({{fluid_file, &fluid}, {body_file, &body}}, state);
    store.commit(step);
  };
  write_with_table(1000);
  std::ofstream(table, std::ios::app) << "10,a\n";
  write_with_table(2000);
  EXPECT_EQ(store.find().state.step, 2000);
  fs::resize_file(table, fs::file_size(table) - 1);
  const FoundCheckpoint found = store.find();
  EXPECT_EQ(found.state.step, 1000);
  ASSERT_EQ(found.skipped.size(), 1U);
  EXPECT_NE(found.skipped[0].find("trajectory.csv lacks rows that it had"), std::string::npos) << found.skipped[0];
  fs::remove(table);
  EXPECT_THROW(static_cast<void>(store.find()), StorageError);
}

TEST_F(Store, BelievesNoManifestThatLeavesAFileOutAndNoStateOfAnotherStep) {
  write(1000);
  write(2000);
  const fs::path newest = folder / "step_000002000";
  auto manifest = nlohmann::json::parse(content_of(newest / "manifest.json"));
  manifest["files"].erase(0);
  std::ofstream(newest / "manifest.json") << manifest;
  EXPECT_EQ(store.find().state.step, 1000);
  fs::remove(newest / "manifest.json");
  fs::copy_file(folder / "step_000001000" / "coupler.json", newest / "coupler.json",
                fs::copy_options::overwrite_existing);
  write_manifest(newest, "case one", 2000);
  const FoundCheckpoint found = store.find();
  EXPECT_EQ(found.state.step, 1000);
  EXPECT_EQ(found.skipped.size(), 1U);
}

TEST_F(Store, FindsATruncatedAndAMissingFile) {
  write(1000);
  write(2000);
  fs::resize_file(folder / "step_000002000" / "body.bin", 3);
  EXPECT_EQ(store.find().state.step, 1000);
  fs::remove(folder / "step_000001000" / "fluid.h5");
  EXPECT_THROW(static_cast<void>(store.find()), StorageError);
}

TEST_F(Store, RefusesTheCheckpointOfAnotherCase) {
  write(1000);
  const CheckpointStore other(folder, "case two");
  try {
    (void)other.find();
    FAIL() << "the checkpoint of another case was used";
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("belongs to another case"), std::string::npos);
  }
}

TEST_F(Store, SaysThatThereIsNothingToResume) {
  EXPECT_THROW(static_cast<void>(store.find()), StorageError);
  EXPECT_EQ(store.newest_bytes(), 0U);
}

TEST_F(Store, LeavesOlderOnesAloneWhenASolverCannotSave) {
  write(1000);
  class FullDisk final : public ConstantDragFluid {
   public:
    FullDisk() : ConstantDragFluid(1.0) {}
    void save(const std::string& path) override {
      throw StorageError(path + " cannot be written (disk full). Free space.");
    }
  } full;
  EXPECT_THROW(store.prepare({{fluid_file, &full}, {body_file, &body}}, state_of(2000)), StorageError);
  EXPECT_EQ(store.find().state.step, 1000);
  write(3000);
  EXPECT_EQ(store.find().state.step, 3000);
}

TEST_F(Store, ReportsAFolderThatCannotBeMade) {
  std::ofstream(folder) << "a file where the folder should be";
  EXPECT_THROW(write(1000), StorageError);
}

TEST_F(Store, KnowsHowMuchRoomACheckpointTakes) {
  write(1000);
  EXPECT_GT(store.newest_bytes(), 500U);
  std::ofstream(folder / "step_000002000") << "a file where a checkpoint should be";
  EXPECT_EQ(store.newest_bytes(), 0U);
  EXPECT_GT(free_bytes(folder), 0U);
  EXPECT_EQ(free_bytes("/nonexistent"), UINTMAX_MAX);
}

TEST(CouplerState, RejectsWhatIsIncomplete) {
  auto json = to_json(state_of(5));
  EXPECT_NO_THROW(coupler_state_from_json(json));
  auto without = json;
  without["previous_loads"].erase("force_N");
  EXPECT_THROW(coupler_state_from_json(without), StorageError);
  auto odd = json;
  odd["previous_loads"]["force_N"] = {1.0, 2.0};
  EXPECT_THROW(coupler_state_from_json(odd), StorageError);
  odd = json;
  odd["swimmers"][0]["turned"].erase(0);
  EXPECT_THROW(coupler_state_from_json(odd), StorageError);
  json["swimmers"][0].erase("power_W");
  EXPECT_THROW(coupler_state_from_json(json), StorageError);
  EXPECT_THROW(coupler_state_from_json(nlohmann::ordered_json::parse("[1", nullptr, false)), StorageError);
}

TEST(CouplerState, RejectsNumbersThatAreNoWholeOnes) {
  nlohmann::ordered_json json = to_json(CouplerState{});
  for (const char* step : {"488888888888888888888", "1.5", "true"}) {
    json["step"] = nlohmann::ordered_json::parse(step);
    EXPECT_THROW(coupler_state_from_json(json), StorageError) << step;
  }
}

TEST(Checksum, DependsOnEveryByteAndOnTheLength) {
  const TemporaryFolder folder;
  const fs::path file = folder.path("checksum.bin");
  const auto of = [&](const std::string& content) {
    std::ofstream(file, std::ios::binary) << content;
    return checksum_of_start(file, content.size()).value();
  };
  const std::string text(100'003, 'x');
  EXPECT_NE(of(text), of(text + std::string(1, '\0')));
  std::string other = text;
  other[70'001] = 'y';
  EXPECT_NE(of(text), of(other));
  EXPECT_EQ(of(text), of(text));
  Checksum in_pieces;
  in_pieces.add(text.substr(0, 12'345));
  in_pieces.add(text.substr(12'345));
  EXPECT_EQ(in_pieces.value(), of(text));
  EXPECT_EQ(checksum_of_start(file, 100).value(), of(text.substr(0, 100)));
  EXPECT_THROW(checksum_of_start(file, 101), StorageError);
  EXPECT_THROW(checksum_of_start("/nonexistent", 1), StorageError);
}

}  // namespace
}  // namespace copepod::coupler
