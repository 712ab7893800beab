#include "system/durable_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <unistd.h>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "limited_file_size.hpp"

namespace copepod {
namespace {

namespace fs = std::filesystem;

class DurableFile : public testing::Test {
 protected:
  DurableFile() : folder_(fs::temp_directory_path() / ("durable_file_test_" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~DurableFile() override { fs::remove_all(folder_); }
  DurableFile(const DurableFile&) = delete;
  DurableFile& operator=(const DurableFile&) = delete;

  [[nodiscard]] std::string path() const { return (folder_ / "file").string(); }
  [[nodiscard]] std::string content() const {
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  [[nodiscard]] auto files() const { return std::distance(fs::directory_iterator(folder_), {}); }
  static void write(const std::string& path, const std::string& text) {
    write_durably(path, std::as_bytes(std::span(text)));
  }

  fs::path folder_;
};

TEST_F(DurableFile, ReplacesTheContentAndLeavesNoOtherFile) {
  write(path(), "a longer text");
  write(path(), "new");
  EXPECT_EQ(content(), "new");
  EXPECT_EQ(files(), 1);
}

TEST_F(DurableFile, ReportsEveryMebibyte) {
  const std::string text(5 * (1 << 19), 'x');  // 2.5 MiB
  int pieces = 0;
  write_durably(path(), std::as_bytes(std::span(text)), [&] { ++pieces; });
  EXPECT_EQ(pieces, 3);
  EXPECT_EQ(content(), text);
}

TEST_F(DurableFile, NamesTheFileInAFolderThatDoesNotExist) {
  const std::string nowhere = (folder_ / "nowhere" / "file").string();
  try {
    write(nowhere, "x");
    FAIL() << "no error";
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find(nowhere + " cannot be written (No such file"), std::string::npos)
        << error.what();
  }
}

TEST_F(DurableFile, LeavesNothingBesideAPathThatCannotBeReplaced) {
  fs::create_directories(folder_ / "file" / "inside");
  EXPECT_THROW(write(path(), "x"), StorageError);
  EXPECT_EQ(files(), 1);
}

TEST_F(DurableFile, KeepsTheOldContentWhenTheDiskIsFull) {
  write(path(), "old");
  {
    const LimitedFileSize full(0);
    EXPECT_THROW(write(path(), "new"), StorageError);
  }
  EXPECT_EQ(content(), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(DurableFile, PublishesAFinishedFileUnderItsName) {
  std::ofstream(path() + ".tmp") << "content";
  publish(path() + ".tmp", path());
  EXPECT_EQ(content(), "content");
  EXPECT_EQ(files(), 1);
  EXPECT_THROW(publish(path() + ".tmp", path()), StorageError) << "it is gone";
}

}  // namespace
}  // namespace copepod
