#include "storage/run_directory.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

namespace fs = std::filesystem;

TEST(RunDirectory, MakesItselfAndItsLogs) {
  const TemporaryFolder folder;
  const RunDirectory directory(folder.path("deep/run"));
  EXPECT_TRUE(fs::is_directory(folder.path("deep/run/logs")));
  EXPECT_TRUE(directory.trajectory_csv().is_absolute());
}

}  // namespace
}  // namespace copepod::coupler
