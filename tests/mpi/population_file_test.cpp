#include "lattice_boltzmann/output/population_file.hpp"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sys/resource.h>
#include <vector>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "storage_case.hpp"

namespace copepod::fluid {
namespace {

constexpr Cell cells = {7, 5, 6};

/// 19 values per cell that depend on the cell only.
template <class T>
std::vector<T> populations_of(const Box& box) {
  std::vector<T> values;
  for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
      for (std::int64_t z = box.low[2]; z < box.high[2]; ++z)
        for (int q = 0; q < 19; ++q)
          values.push_back(static_cast<T>(1.0 / static_cast<double>(1 + q + 19 * (z + 6 * (y + 5 * x)))));
  return values;
}

FluidState state_on(const Box& box, int samples) {
  FluidState state;
  state.kinematics.step = 41;
  state.kinematics.resize(3);
  for (int i = 0; i < 9; ++i) {
    state.kinematics.position_m(i % 3, i / 3) = i;
    state.kinematics.velocity_m_per_s(i % 3, i / 3) = 10 + i;
    state.kinematics.angular_velocity_rad_per_s(i % 3, i / 3) = 20 + i;
  }
  for (int i = 0; i < 12; ++i) state.kinematics.orientation_wxyz(i % 4, i / 4) = 30 + i;
  state.absorbed_mass.resize(2, 3);
  state.absorbed_mass << 0.1, 0.2, 0.3, 4.0, 5.0, 6.0;
  state.sampling = {12, 10};
  state.momentum = {{0.7, -0.8, 0.9}, 10.0};
  for (int sample = 0; sample < samples; ++sample) state.mean.add(numbered_fields(box));
  return state;
}

const PopulationHeader header{123, cells, 42};

class Checkpoint : public testing::Test {
 protected:
  template <class T>
  void save(int samples) {
    const auto get = [](const Box& piece, std::span<T> values) {
      std::ranges::copy(populations_of<T>(piece), values.begin());
    };
    save_populations<T>(path_, ranks_, header, box_, get, state_on(box_, samples));
  }

  /// Restores on blocks that differ from those of `save`: cut along z only.
  template <class T>
  PopulationHeader restore(const PopulationHeader& expected = {123, cells, 0}) {
    const std::int64_t n = ranks_.size();
    other_box_ = {{0, 0, ranks_.rank() * cells[2] / n}, {cells[0], cells[1], (ranks_.rank() + 1) * cells[2] / n}};
    std::int64_t cells_taken = 0;
    const auto take = [&](const PopulationHeader&, const Box& piece, std::span<const T> values) {
      EXPECT_TRUE(std::ranges::equal(values, populations_of<T>(piece)));
      cells_taken += piece.volume();
    };
    const PopulationHeader got = restore_populations<T>(path_, ranks_, expected, other_box_, take, state_);
    EXPECT_EQ(cells_taken, other_box_.volume());
    return got;
  }

  template <class Action>
  std::string message_of(const Action& action) {
    try {
      action();
    } catch (const StorageError& error) {
      return error.what();
    }
    return "no error";
  }

  SolverContext context_;
  MpiCommunicator ranks_{context_};
  SharedFolder folder_{ranks_};
  std::string path_ = folder_.path() + "/fluid.h5";
  Box box_ = BlockPartition(cells, ranks_.size()).block(ranks_.rank());
  Box other_box_;
  FluidState state_;
};

TEST_F(Checkpoint, RestoresDoublesOnAnotherDecomposition) {
  save<double>(0);
  EXPECT_EQ(restore<double>().step, 42);
  EXPECT_EQ(state_.mean.samples(), 0);
}

TEST_F(Checkpoint, RestoresFloatsOnAnotherDecomposition) {
  save<float>(0);
  EXPECT_EQ(restore<float>().step, 42);
}

TEST_F(Checkpoint, RestoresBodiesAndTheMeanField) {
  save<double>(3);
  restore<double>();
  const FluidState expected = state_on(other_box_, 3);
  EXPECT_EQ(state_.kinematics.step, 41);
  EXPECT_EQ(state_.kinematics.position_m, expected.kinematics.position_m);
  EXPECT_EQ(state_.kinematics.orientation_wxyz, expected.kinematics.orientation_wxyz);
  EXPECT_EQ(state_.kinematics.velocity_m_per_s, expected.kinematics.velocity_m_per_s);
  EXPECT_EQ(state_.kinematics.angular_velocity_rad_per_s, expected.kinematics.angular_velocity_rad_per_s);
  EXPECT_EQ(state_.absorbed_mass, expected.absorbed_mass);
  EXPECT_EQ(state_.momentum, expected.momentum);
  EXPECT_EQ(state_.mean.samples(), 3);
  EXPECT_EQ(state_.sampling, (Sampling{12, 10}));
  EXPECT_EQ(state_.mean.sums().density_kg_per_m3, expected.mean.sums().density_kg_per_m3);
  EXPECT_EQ(state_.mean.sums().velocity_m_per_s, expected.mean.sums().velocity_m_per_s);
  EXPECT_EQ(state_.mean.sums().body, expected.mean.sums().body);
}

TEST_F(Checkpoint, ReplacesAnEarlierOneOfTheSameName) {
  save<double>(2);
  save<double>(0);
  restore<double>();
  EXPECT_EQ(state_.mean.samples(), 0);
  EXPECT_FALSE(std::filesystem::exists(path_ + ".tmp"));
}

TEST_F(Checkpoint, NoticesASingleFlippedBit) {
  save<double>(0);
  folder_.barrier();
  if (ranks_.rank() == 0) {
    // The populations lie at the end of the file or near it: the file is mostly them.
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    const auto middle = static_cast<std::streamoff>(std::filesystem::file_size(path_) / 2);
    file.seekg(middle);
    const int byte = file.get();
    file.seekp(middle);
    file.put(static_cast<char>(byte ^ 4));
  }
  folder_.barrier();
  const auto ignore = [](const PopulationHeader&, const Box&, std::span<const double>) {};
  const std::string message =
      message_of([&] { restore_populations<double>(path_, ranks_, header, box_, ignore, state_); });
  EXPECT_NE(message.find("damaged"), std::string::npos) << message;
}

TEST_F(Checkpoint, RefusesATruncatedFile) {
  save<double>(0);
  folder_.barrier();
  if (ranks_.rank() == 0) std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  folder_.barrier();
  const std::string message = message_of([&] { restore<double>(); });
  EXPECT_NE(message.find("cannot open"), std::string::npos) << message;
}

TEST_F(Checkpoint, RefusesAFileThatIsMissing) {
  const std::string message = message_of([&] { restore<double>(); });
  EXPECT_NE(message.find(path_), std::string::npos) << message;
}

TEST_F(Checkpoint, RefusesOneOfAnotherCase) {
  save<double>(0);
  EXPECT_NE(message_of([&] { restore<double>({124, cells, 0}); }).find("another case"), std::string::npos);
  EXPECT_NE(message_of([&] {
              restore<double>({123, {7, 5, 7}, 0});
            }).find("7×5×6 cells (the case has 7×5×7)"),
            std::string::npos);
}

TEST_F(Checkpoint, ReportsAFullDiskOnEveryRankAndKeepsTheEarlierOne) {
  save<double>(0);
  folder_.barrier();
  // A limit on the size of files acts like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{8192, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string message = message_of([&] { save<double>(3); });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(message.find("cannot"), std::string::npos) << message;
  restore<double>();
  EXPECT_EQ(state_.mean.samples(), 0);
}

}  // namespace
}  // namespace copepod::fluid
