#include "storage/table_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>
#include <utility>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "contract/errors.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {
namespace {

std::uint64_t head_of(const std::string& path) { return path.ends_with(".npy") ? NpyFile::head_bytes : 0; }

std::string start_of_npy_head(const std::string& type) {
  constexpr std::uint64_t before_text = 10;
  constexpr std::uint64_t text = NpyFile::head_bytes - before_text;
  std::string head = "\x93NUMPY\x01";
  for (const std::uint64_t byte : {std::uint64_t{0}, text & 0xff, text >> 8}) head += static_cast<char>(byte);
  return head + "{'descr': " + type + ", 'fortran_order': False, 'shape': (";
}

}  // namespace

struct Checksum::State {
  XXH3_state_t hash;
};

Checksum::Checksum() : state_(new State, [](State* state) { delete state; }) { XXH3_64bits_reset(&state_->hash); }

void Checksum::add(std::string_view bytes) { XXH3_64bits_update(&state_->hash, bytes.data(), bytes.size()); }

std::uint64_t Checksum::value() const { return XXH3_64bits_digest(&state_->hash); }

Checksum checksum_of_start(const std::filesystem::path& file, std::uint64_t bytes, std::uint64_t skipped) {
  constexpr std::uint64_t piece_bytes = std::uint64_t{1} << 20;
  Checksum checksum;
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(skipped);
  std::vector<char> piece(piece_bytes);
  while (bytes > 0) {
    const auto size = static_cast<std::streamsize>(std::min(bytes, piece_bytes));
    if (!stream.read(piece.data(), size))
      throw StorageError(file.string() + " cannot be read (missing, too short or a bad disk). Use another checkpoint.");
    checksum.add({piece.data(), static_cast<std::size_t>(size)});
    bytes -= static_cast<std::uint64_t>(size);
  }
  return checksum;
}

TableFile::TableFile(std::string path, const std::optional<TableEnd>& end, std::uint64_t head)
    : path_(std::move(path)), head_(head) {
  if (end) {
    if (const std::string damage = find_damage(path_, *end); !damage.empty())
      throw StorageError(damage + " (the run cannot continue it). Restore the file, or start a new run.");
    bytes_ = end->bytes;
    checksum_ = checksum_of_start(path_, bytes_, head_);
  }
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) fail("Choose another --out folder.");
  const std::uint64_t kept = end ? head_ + bytes_ : 0;
  if (::ftruncate(file_, static_cast<off_t>(kept)) != 0 && kept > 0)  // 0: a device, for tests
    fail("Free space on that disk and run again.");
}

TableFile::~TableFile() {
  try {
    flush();
  } catch (const Error&) {
    // The run is failing already; whole rows written before stay as they are.
  }
  ::close(file_);
}

void TableFile::flush() {
  write(head_ + bytes_, buffer_);
  checksum_.add(buffer_);
  bytes_ += buffer_.size();
  buffer_.clear();
  if (make_head_) write(0, make_head_(bytes_));
  flushed_ = Clock::now();
}

TableEnd TableFile::sync() {
  flush();
  ::fsync(file_);
  return {bytes_, checksum_.value()};
}

void TableFile::end_row() {
  constexpr std::size_t most_buffered = std::size_t{1} << 20;
  if (buffer_.size() > most_buffered || Clock::now() - flushed_ >= std::chrono::seconds(1)) flush();
}

void TableFile::write(std::uint64_t position, std::string_view bytes) {
  if (!write_all(file_, position, std::as_bytes(std::span(bytes)))) fail("Free space on that disk and run again.");
}

void TableFile::fail(const std::string& remedy) const {
  throw StorageError(path_ + " cannot be written (" + std::strerror(errno) + "). " + remedy_for(errno, remedy));
}

CsvFile::CsvFile(const std::string& path, const std::string& header, const std::optional<TableEnd>& end)
    : TableFile(path, end) {
  std::string found;
  if (end && (!std::getline(std::ifstream(path), found) || found != header))
    throw StorageError(path + " has other columns (the run cannot continue it). Ask for those, or start a new run.");
  if (!end) append(header + '\n');
  flush();
}

NpyFile::NpyFile(const std::string& path, const std::string& type, std::uint64_t sample_bytes,
                 const std::optional<TableEnd>& end)
    : TableFile(path, end, head_bytes) {
  const std::string start = start_of_npy_head(type);
  std::string found(start.size(), '\0');
  if (end && (!std::ifstream(path, std::ios::binary).read(found.data(), found.size()) || found != start))
    throw StorageError(path +
                       " is of other bodies (the run cannot continue it). Restore the file, or start a new run.");
  make_head_ = [start, sample_bytes](std::uint64_t bytes) {
    std::string head = start + std::to_string(bytes / sample_bytes) + ",), }";
    head.resize(head_bytes - 1, ' ');
    return head + '\n';
  };
  flush();
}

void NpyFile::add(std::span<const std::span<const std::byte>> values) {
  for (const auto& field : values) append({reinterpret_cast<const char*>(field.data()), field.size()});
  end_row();
}

std::string find_damage(const std::string& path, const TableEnd& end) try {
  return checksum_of_start(path, end.bytes, head_of(path)).value() == end.checksum ? "" : path + " has changed";
} catch (const StorageError&) {
  return path + " lacks rows that it had";
}

}  // namespace copepod::coupler
