#include "recording/record_file.hpp"

#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <iostream>
#include <unistd.h>
#include <utility>
#include <zlib.h>

#include "contract/errors.hpp"
#include "system/block_signals.hpp"
#include "system/storage_errno.hpp"
#include "system/write_all.hpp"

namespace copepod::recording {

namespace {

static_assert(std::endian::native == std::endian::little, "block heads are little-endian");

constexpr std::array<unsigned char, 8> kMagic{0x89, 'C', 'P', 'D', 'R', 'E', 'C', '\n'};
constexpr std::size_t kHeadBytes = 2 * sizeof(std::uint32_t);
constexpr std::size_t kWorthWriting = std::size_t{1} << 20;
constexpr std::size_t kMostPending = std::size_t{64} << 20;
constexpr std::chrono::milliseconds kInterval{100};

void put(std::vector<std::byte>& target, std::span<const std::byte> bytes) {
  const std::size_t place = target.size();
  target.resize(place + bytes.size());
  if (!bytes.empty()) std::memcpy(target.data() + place, bytes.data(), bytes.size());
}

/// The content's checksum is filled in later, by the writing thread.
void put_block(std::vector<std::byte>& target, std::span<const std::byte> head, std::span<const std::byte> tail) {
  const std::array<std::uint32_t, 2> length_and_crc{static_cast<std::uint32_t>(head.size() + tail.size()), 0};
  put(target, std::as_bytes(std::span(length_and_crc)));
  put(target, head);
  put(target, tail);
}

void fill_checksums(std::vector<std::byte>& blocks) {
  std::size_t place = 0;
  while (place < blocks.size()) {
    std::uint32_t length = 0;
    std::memcpy(&length, &blocks[place], sizeof length);
    const auto* content = reinterpret_cast<const Bytef*>(blocks.data() + place + kHeadBytes);
    const auto crc = static_cast<std::uint32_t>(crc32(0, content, length));
    std::memcpy(&blocks[place + sizeof length], &crc, sizeof crc);
    place += kHeadBytes + length;
  }
}

}  // namespace

RecordFile::RecordFile(const std::string& path, Bytes schema)
    : path_(path), descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600)) {
  if (descriptor_ < 0) {
    throw StorageError("the recording " + path + " cannot be made (" + std::strerror(errno) + "). " +
                       remedy_for(errno, "Check the run directory, or switch output.wire and output.trace off."));
  }
  if (!write_all(descriptor_, std::as_bytes(std::span(kMagic)))) problem_ = std::strerror(errno);
  pending_.reserve(2 * kWorthWriting);
  put_block(pending_, schema, {});
  thread_ = std::thread([this] {
    block_signals();
    write_in_background();
  });
}

RecordFile::~RecordFile() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  work_.notify_one();
  thread_.join();
  ::close(descriptor_);
}

void RecordFile::append(Bytes head, Bytes tail) {
  std::unique_lock lock(mutex_);
  room_.wait(lock, [this] { return pending_.size() < kMostPending || !problem_.empty(); });
  if (!problem_.empty()) return;
  put_block(pending_, head, tail);
  if (pending_.size() > kWorthWriting) work_.notify_one();
}

std::string RecordFile::problem() {
  const std::lock_guard lock(mutex_);
  if (problem_.empty()) return {};
  return "The recording " + path_ + " is incomplete (" + problem_ + "). Free some space, or record less.";
}

void RecordFile::write_in_background() {
  std::vector<std::byte> blocks;
  blocks.reserve(2 * kWorthWriting);
  std::unique_lock lock(mutex_);
  for (bool last = false; !last;) {
    work_.wait_for(lock, kInterval, [this] { return closing_ || pending_.size() > kWorthWriting; });
    last = closing_;
    std::swap(blocks, pending_);
    lock.unlock();
    room_.notify_one();
    write(blocks);
    blocks.clear();
    lock.lock();
  }
}

void RecordFile::write(std::vector<std::byte>& blocks) {
  fill_checksums(blocks);
  if (write_all(descriptor_, blocks)) return;
  {
    const std::string reason = std::strerror(errno);
    const std::lock_guard lock(mutex_);
    problem_ = reason;
  }
  room_.notify_one();
  std::cerr << "warning: " << problem() << std::endl;
}

}  // namespace copepod::recording
