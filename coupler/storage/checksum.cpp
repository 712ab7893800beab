#include "storage/checksum.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <span>
#include <unistd.h>
#include <utility>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "contract/errors.hpp"
#include "storage/csv_file.hpp"
#include "storage/hdf5_table.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {

struct Checksum::State {
  XXH3_state_t hash;
};

Checksum::Checksum() : state_(std::make_unique<State>()) { XXH3_64bits_reset(&state_->hash); }
Checksum::Checksum(Checksum&&) noexcept = default;
Checksum& Checksum::operator=(Checksum&&) noexcept = default;
Checksum::~Checksum() = default;

void Checksum::add(std::string_view bytes) { XXH3_64bits_update(&state_->hash, bytes.data(), bytes.size()); }

std::uint64_t Checksum::value() const { return XXH3_64bits_digest(&state_->hash); }

Checksum checksum_of_start(const std::filesystem::path& file, std::uint64_t bytes) {
  constexpr std::uint64_t piece_bytes = std::uint64_t{1} << 20;
  Checksum checksum;
  std::ifstream stream(file, std::ios::binary);
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

TableFile::TableFile(std::string path, const std::optional<TableEnd>& end) : path_(std::move(path)) {
  if (end) {
    if (const std::string damage = find_damage(path_, *end); !damage.empty())
      throw StorageError(damage + " (the run cannot continue it). Restore the file, or start a new run.");
    bytes_ = end->bytes;
  }
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) fail("Choose another --out folder.");
}

TableFile::~TableFile() { ::close(file_); }

TableEnd TableFile::sync() {
  flush();
  ::fsync(file_);
  return {bytes_, checksum_.value()};
}

void TableFile::write(std::uint64_t position, std::string_view bytes) {
  if (!write_all(file_, position, std::as_bytes(std::span(bytes)))) fail("Free space on that disk and run again.");
}

void TableFile::resize(std::uint64_t bytes) {
  if (::ftruncate(file_, static_cast<off_t>(bytes)) != 0 && bytes > 0)  // 0: a device, for tests
    fail("Free space on that disk and run again.");
}

void TableFile::fail(const std::string& remedy) const {
  throw StorageError(path_ + " cannot be written (" + std::strerror(errno) + "). " + remedy_for(errno, remedy));
}

std::string find_damage(const std::string& path, const TableEnd& end) {
  const std::optional<Checksum> checksum =
      path.ends_with(hdf5_suffix) ? Hdf5Table::checksum_of_start(path, end) : CsvFile::checksum_of_start(path, end);
  if (!checksum) return path + " lacks rows that it had";
  return checksum->value() == end.checksum ? "" : path + " has changed";
}

}  // namespace copepod::coupler
