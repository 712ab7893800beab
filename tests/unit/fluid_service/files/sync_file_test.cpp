#include "files/sync_file.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::fluid {
namespace {

TEST(Publish, GivesAFinishedFileItsName) {
  const std::string path = testing::TempDir() + "/published";
  std::ofstream(path + ".tmp") << "contents";
  publish(path + ".tmp", path);
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(path + ".tmp"));
  std::filesystem::remove(path);
}

TEST(Publish, ReportsAFileThatIsNotThere) {
  EXPECT_THROW(publish(testing::TempDir() + "/nothing.tmp", testing::TempDir() + "/nothing"), StorageError);
}

}  // namespace
}  // namespace copepod::fluid
