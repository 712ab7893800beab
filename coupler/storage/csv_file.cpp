#include "storage/csv_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

#include "contract/errors.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {

std::string csv_field(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string field = "\"";
  for (const char c : name) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

std::optional<Checksum> CsvFile::checksum_of_start(const std::string& path, const TableEnd& end) try {
  return coupler::checksum_of_start(path, end.bytes);
} catch (const StorageError&) {
  return std::nullopt;
}

namespace {

/// Checksum of what a table still holds up to `end`.
Checksum intact_start(const std::string& path, const TableEnd& end) {
  if (const std::string damage = find_damage(path, end); !damage.empty())
    throw StorageError(damage + " (the run cannot continue it). Restore the file, or start a new run.");
  return checksum_of_start(path, end.bytes);
}

}  // namespace

CsvFile::CsvFile(const std::string& path, const std::string& header, const std::optional<TableEnd>& end)
    : path_(path),
      checksum_(end ? intact_start(path, *end) : Checksum()),
      file_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)),
      flushed_(std::chrono::steady_clock::now()) {
  if (file_ < 0) {
    throw StorageError(path + " cannot be written (" + std::strerror(errno) + "). " +
                       remedy_for(errno, "Choose another --out folder."));
  }
  if (!end) buffer_ = header + '\n';
  cut_at(end ? end->bytes : 0);
  flush();
}

void CsvFile::cut_at(std::uint64_t bytes) {
  const auto size = static_cast<off_t>(bytes);
  if (::ftruncate(file_, size) != 0 || ::lseek(file_, size, SEEK_SET) != size) {
    const std::string reason = std::strerror(errno);
    if (bytes > 0) throw StorageError(path_ + " cannot be shortened (" + reason + "). Check its permissions.");
  }
  bytes_ = bytes;
}

CsvFile::~CsvFile() {
  try {
    flush();
  } catch (const Error&) {
    // The run is failing already; whole lines written before stay as they are.
  }
  ::close(file_);
}

void CsvFile::add(std::string_view row) {
  buffer_.append(row) += '\n';
  constexpr std::size_t most_buffered = std::size_t{1} << 20;
  const bool due = std::chrono::steady_clock::now() - flushed_ >= std::chrono::seconds(1);
  if (due || buffer_.size() > most_buffered) flush();
}

void CsvFile::flush() {
  std::size_t written = 0;
  while (written < buffer_.size()) {
    const ssize_t count = ::write(file_, buffer_.data() + written, buffer_.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      throw StorageError(path_ + " cannot be written (" + std::strerror(errno) + "). " +
                         remedy_for(errno, "Free space on that disk and run again."));
    }
    written += static_cast<std::size_t>(count);
  }
  checksum_.add(buffer_);
  bytes_ += buffer_.size();
  buffer_.clear();
  flushed_ = std::chrono::steady_clock::now();
}

TableEnd CsvFile::sync() {
  flush();
  ::fsync(file_);
  return {bytes_, checksum_.value()};
}

}  // namespace copepod::coupler
