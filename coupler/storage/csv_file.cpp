#include "storage/csv_file.hpp"

#include "contract/errors.hpp"

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

CsvFile::CsvFile(const std::string& path, const std::string& header, const std::optional<TableEnd>& end)
    : TableFile(path, end) {
  if (end)
    checksum_ = coupler::checksum_of_start(path, bytes_);
  else
    buffer_ = header + '\n';
  resize(bytes_);
  flush();
}

CsvFile::~CsvFile() {
  try {
    flush();
  } catch (const Error&) {
    // The run is failing already; whole lines written before stay as they are.
  }
}

void CsvFile::add(std::string_view row) {
  buffer_.append(row) += '\n';
  constexpr std::size_t most_buffered = std::size_t{1} << 20;
  if (is_due() || buffer_.size() > most_buffered) flush();
}

void CsvFile::flush() {
  write(bytes_, buffer_);
  checksum_.add(buffer_);
  bytes_ += buffer_.size();
  buffer_.clear();
  flushed_ = Clock::now();
}

}  // namespace copepod::coupler
