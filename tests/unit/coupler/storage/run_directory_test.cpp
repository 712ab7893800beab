#include "storage/run_directory.hpp"

#include <filesystem>

#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

namespace fs = std::filesystem;

fs::path fresh_folder() {
  const fs::path folder = fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  fs::remove_all(folder);
  return folder;
}

TEST(RunDirectory, MakesItselfAndItsLogs) {
  const fs::path folder = fresh_folder();
  const RunDirectory directory(folder / "deep" / "run");
  EXPECT_TRUE(fs::is_directory(folder / "deep" / "run" / "logs"));
  EXPECT_TRUE(directory.trajectory().is_absolute());
}

}  // namespace
}  // namespace copepod::coupler
