#include "storage/run_directory.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

namespace fs = std::filesystem;

fs::path fresh_folder() {
  const fs::path folder =
      fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  fs::remove_all(folder);
  return folder;
}

TEST(WriteAtomically, ReplacesAFileAndLeavesNoOther) {
  const fs::path folder = fresh_folder();
  fs::create_directories(folder);
  write_atomically(folder / "file", "old");
  write_atomically(folder / "file", "new");
  std::ostringstream text;
  text << std::ifstream(folder / "file").rdbuf();
  EXPECT_EQ(text.str(), "new");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST(WriteAtomically, ReportsAFileThatCannotBeWritten) {
  const fs::path folder = fresh_folder();
  EXPECT_THROW(write_atomically(folder / "missing" / "file", "x"), StorageError);
  fs::create_directories(folder / "file" / "inside");
  EXPECT_THROW(write_atomically(folder / "file", "x"), StorageError);
  EXPECT_FALSE(fs::exists(folder / "file.tmp"));
}

TEST(RunDirectory, MakesItselfAndItsLogs) {
  const fs::path folder = fresh_folder();
  const RunDirectory directory(folder / "deep" / "run");
  EXPECT_TRUE(fs::is_directory(folder / "deep" / "run" / "logs"));
  EXPECT_TRUE(directory.trajectory().is_absolute());
}

}  // namespace
}  // namespace copepod::coupler
