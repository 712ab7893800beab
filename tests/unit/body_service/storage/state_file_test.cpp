#include "storage/state_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "limited_file_size.hpp"

namespace copepod::body {
namespace {

BodySetup two_beads() {
  BodySetup setup = setup_of({bead("a", {0, 0, 0}), bead("b", {0, 0, 2e-5})}, 1e-9);
  setup.springs.emplace_back();
  setup.springs[0].body_B = 1;
  return setup;
}

TEST(LayoutDigest, ChangesWithWhatAStateBelongsTo) {
  const std::vector<std::function<void(BodySetup&)>> changes = {
      [](auto& s) { s.step_s *= 2; },
      [](auto& s) { s.integrator = Integrator::semi_implicit_euler; },
      [](auto& s) { s.bodies[1].name.push_back('c'); },
      [](auto& s) { s.bodies[1].shape.radius_m *= 2; },
      [](auto& s) {
        s.bodies[1].shape = {ShapeKind::capsule, s.bodies[1].shape.radius_m, 1.0};
      },
      [](auto& s) { s.bodies[1].motion = MotionKind::fixed; },
      [](auto& s) { s.bodies.pop_back(); },
  };
  const std::uint64_t original = layout_digest(two_beads());
  BodySetup driven_in_another_way = two_beads();
  driven_in_another_way.springs.clear();
  driven_in_another_way.bodies[0].mass_kg *= 2;
  EXPECT_EQ(layout_digest(driven_in_another_way), original);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    BodySetup changed = two_beads();
    changes[i](changed);
    EXPECT_NE(layout_digest(changed), original) << "change " << i;
  }
}

TEST(StateDigest, SeesASingleBitOfEveryPartOfTheState) {
  MotionState state;
  state.resize(2);
  for (auto* matrix : {&state.position_m, &state.velocity_m_per_s, &state.angular_momentum_N_m_s}) {
    matrix->setOnes();
  }
  state.orientation_wxyz.setOnes();
  const std::uint64_t original = state_digest(7, state);
  EXPECT_NE(state_digest(8, state), original);
  for (double* number : {&state.position_m(2, 1), &state.orientation_wxyz(3, 1), &state.velocity_m_per_s(0, 0),
                         &state.angular_momentum_N_m_s(1, 1)}) {
    *number = std::nextafter(1.0, 2.0);
    EXPECT_NE(state_digest(7, state), original);
    *number = 1.0;
  }
  EXPECT_EQ(state_digest(7, state), original);
}

class StateFile : public testing::Test {
 protected:
  StateFile() : folder_(std::filesystem::temp_directory_path() / ("state_file_test_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    state_.resize(3);
    state_.position_m.setRandom();
    state_.orientation_wxyz.setRandom();
    state_.velocity_m_per_s.setRandom();
    state_.angular_momentum_N_m_s.setRandom();
    state_.velocity_m_per_s(0, 0) = -0.0;
    state_.velocity_m_per_s(1, 0) = std::numeric_limits<double>::denorm_min();
  }
  ~StateFile() override { std::filesystem::remove_all(folder_); }
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  [[nodiscard]] std::string path() const { return (folder_ / "body.state").string(); }
  void write() const { write_state(path(), layout_digest, 42, state_); }
  [[nodiscard]] std::string refusal(std::uint64_t digest = layout_digest) const {
    MotionState state = state_;
    return reason_of<StorageError>([&] { read_state(path(), digest, state); });
  }
  [[nodiscard]] std::string bytes() const {
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void replace(const std::string& bytes) const { std::ofstream(path(), std::ios::binary | std::ios::trunc) << bytes; }

  static constexpr std::uint64_t layout_digest = 0x123456789abcdef0ULL;
  std::filesystem::path folder_;
  MotionState state_;
};

bool same_bits(const double* first, const double* second, Eigen::Index count) {
  return std::equal(first, first + count, second,
                    [](double a, double b) { return a == b && std::signbit(a) == std::signbit(b); });
}

// A slow disk is not taken for one that hangs.
TEST_F(StateFile, ShowsProgressWithEveryMegabyte) {
  state_.resize(25'000);  // 2.6 MB
  for (auto* matrix : {&state_.position_m, &state_.velocity_m_per_s, &state_.angular_momentum_N_m_s})
    matrix->setRandom();
  state_.orientation_wxyz.setRandom();
  int signs = 0;
  const auto count = [&signs] { ++signs; };
  write_state(path(), layout_digest, 42, state_, count);
  EXPECT_GE(signs, 3);
  signs = 0;
  EXPECT_EQ(read_state(path(), layout_digest, state_, count), 42);
  EXPECT_GE(signs, 3);
}

TEST_F(StateFile, GivesBackEveryBit) {
  write();
  MotionState read;
  read.resize(3);
  EXPECT_EQ(read_state(path(), layout_digest, read), 42);
  EXPECT_TRUE(same_bits(read.position_m.data(), state_.position_m.data(), 9));
  EXPECT_TRUE(same_bits(read.orientation_wxyz.data(), state_.orientation_wxyz.data(), 12));
  EXPECT_TRUE(same_bits(read.velocity_m_per_s.data(), state_.velocity_m_per_s.data(), 9));
  EXPECT_TRUE(same_bits(read.angular_momentum_N_m_s.data(), state_.angular_momentum_N_m_s.data(), 9));
}

TEST_F(StateFile, LeavesNoUnfinishedFileBeside) {
  write();
  write();
  const auto files = std::distance(std::filesystem::directory_iterator(folder_), {});
  EXPECT_EQ(files, 1);
}

TEST_F(StateFile, RefusesAMissingFile) { EXPECT_TRUE(contains(refusal(), "could not be opened (No such file")); }

TEST_F(StateFile, RefusesEveryTruncatedFile) {
  write();
  const std::string whole = bytes();
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    replace(whole.substr(0, length));
    EXPECT_FALSE(refusal().empty()) << "cut after " << length << " bytes";
  }
  replace(whole.substr(0, whole.size() - 1));
  EXPECT_TRUE(contains(refusal(), "is damaged"));
}

TEST_F(StateFile, RefusesAFileThatIsTooLong) {
  write();
  for (const std::size_t extra : {1U, 8U, 100U}) {
    replace(bytes().substr(0, 8 * (7 + 39)) + std::string(extra, '\0'));
    EXPECT_TRUE(contains(refusal(), "is damaged")) << extra;
  }
}

TEST_F(StateFile, RefusesAFlippedBitAnywhere) {
  write();
  const std::string whole = bytes();
  ASSERT_EQ(whole.size(), 8U * (7 + 39));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    replace(damaged);
    EXPECT_FALSE(refusal().empty()) << "byte " << i;
  }
}

TEST_F(StateFile, RefusesTheStateOfAnotherCase) {
  write();
  EXPECT_TRUE(contains(refusal(layout_digest + 1), "another case"));
}

TEST_F(StateFile, RefusesAForeignFile) {
  replace(std::string(1000, 'x'));
  EXPECT_TRUE(contains(refusal(), "not a saved body state"));
}

TEST_F(StateFile, ReportsAFolderThatDoesNotExist) {
  const std::string nowhere = (folder_ / "nowhere" / "body.state").string();
  EXPECT_TRUE(
      contains(reason_of<StorageError>([&] { write_state(nowhere, layout_digest, 0, state_); }), "cannot be written"));
}

TEST_F(StateFile, ReportsAFullDisk) {
  const LimitedFileSize full(0);
  EXPECT_TRUE(contains(reason_of<StorageError>([&] { write(); }), "cannot be written (File too large)"));
}

}  // namespace
}  // namespace copepod::body
