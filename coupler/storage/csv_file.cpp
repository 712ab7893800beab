#include "storage/csv_file.hpp"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>

#include "contract/errors.hpp"

namespace copepod::coupler {

std::string csv_field(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string field = "\"";
  for (const char c : name) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

CsvFile::CsvFile(const std::string& path, const std::string& header,
                 const std::function<bool(std::string_view row)>& keep)
    : path_(path),
      header_(header),
      file_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)),
      flushed_(std::chrono::steady_clock::now()) {
  if (file_ < 0) {
    throw StorageError(path + " cannot be written (" + std::strerror(errno) + "). Choose another --out folder.");
  }
  keep_rows(keep);
  flush();
}

void CsvFile::keep_rows(const std::function<bool(std::string_view)>& keep) {
  std::ifstream stream(path_, std::ios::binary);
  std::string line;
  std::int64_t kept = 0;
  if (keep && std::getline(stream, line) && line == header_) {
    kept = static_cast<std::int64_t>(line.size()) + 1;
    while (std::getline(stream, line) && !stream.eof() && keep(line))
      kept += static_cast<std::int64_t>(line.size()) + 1;
  } else {
    buffer_ = header_ + '\n';
  }
  if (::ftruncate(file_, kept) != 0 || ::lseek(file_, kept, SEEK_SET) != kept) {
    const std::string reason = std::strerror(errno);
    if (kept > 0) throw StorageError(path_ + " cannot be shortened (" + reason + "). Check its permissions.");
  }
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
      throw StorageError(path_ + " cannot be written (" + std::strerror(errno) +
                         "). Free space on that disk and run again.");
    }
    written += static_cast<std::size_t>(count);
  }
  buffer_.clear();
  flushed_ = std::chrono::steady_clock::now();
}

void CsvFile::sync() {
  flush();
  ::fsync(file_);
}

}  // namespace copepod::coupler
