#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace copepod::recording {

/// Appends records to a new file from a thread of its own, so that recording never waits for a disk.
///
///   file  = magic, block, block, …       the first block is the schema, all others are copepod.v1.Record
///   magic = 89 43 50 44 52 45 43 0A      "\x89CPDREC\n"
///   block = length (4 bytes), CRC-32 of the content (4 bytes), content; little-endian [docs/recording.md]
///
/// `append` copies into memory; the file follows within 0.1 s. A process that is killed leaves a file that
/// ends somewhere, perhaps inside a block: readers take every block before.
class RecordFile {
 public:
  using Bytes = std::span<const std::byte>;

  /// @param schema  serialised google.protobuf.FileDescriptorSet
  /// @throws StorageError if the file exists or cannot be made
  RecordFile(const std::string& path, Bytes schema);
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;
  /// Writes what is left.
  ~RecordFile();

  /// Adds a block whose content is `head` followed by `tail`. Waits only if the disk is 64 MiB behind. Once
  /// the disk is full nothing more is recorded.
  void append(Bytes head, Bytes tail = {});

  /// Why recording stopped early; empty if it did not.
  [[nodiscard]] std::string problem();

 private:
  void write_in_background();
  void write(std::vector<std::byte>& blocks);

  std::string path_;
  int descriptor_;
  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable room_;
  std::vector<std::byte> pending_;
  bool closing_ = false;
  std::string problem_;
  std::thread thread_;
};

}  // namespace copepod::recording
