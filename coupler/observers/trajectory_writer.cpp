#include "observers/trajectory_writer.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>

#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

constexpr const char* header =
    "step,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_per_s,vy_m_per_s,vz_m_per_s,wx_rad_per_s,wy_rad_per_s,wz_"
    "rad_per_s,"
    "fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,drive_fx_N,drive_fy_N,drive_fz_N\n";

template <typename Number>
void append(std::string& line, Number number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  line.append(text.data(), end);
}

template <typename Column>
void append_all(std::string& line, const Column& column) {
  for (Eigen::Index i = 0; i < column.size(); ++i) {
    line += ',';
    append(line, column[i]);
  }
}

/// A name in quotes where CSV needs them.
std::string csv_field(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string field = "\"";
  for (const char c : name) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

}  // namespace

TrajectoryWriter::TrajectoryWriter(const std::string& path, std::vector<std::string> body_names, double step_s,
                                   std::int64_t every_steps, std::int64_t from_step, std::int64_t sample_from)
    : path_(path),
      body_names_(std::move(body_names)),
      step_s_(step_s),
      every_steps_(every_steps),
      sample_from_(sample_from),
      file_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)),
      flushed_(std::chrono::steady_clock::now()) {
  if (file_ < 0) {
    throw StorageError(path + " cannot be written (" + std::strerror(errno) + "). Choose another --out folder.");
  }
  for (std::string& name : body_names_) name = csv_field(name);
  keep_rows_before(from_step);
  flush();
}

/// Cuts the file after its last whole row of a step before `step`; what is left then ends with a sample that
/// was taken.
void TrajectoryWriter::keep_rows_before(std::int64_t step) {
  std::ifstream stream(path_, std::ios::binary);
  std::string line;
  std::int64_t kept = 0;
  const bool usable = step > 0 && std::getline(stream, line) && line + "\n" == header;
  if (usable) {
    kept = static_cast<std::int64_t>(line.size()) + 1;
    while (std::getline(stream, line) && !stream.eof()) {
      std::int64_t row_step = 0;
      const auto parsed = std::from_chars(line.data(), line.data() + line.size(), row_step);
      if (parsed.ec != std::errc{} || row_step >= step) break;
      kept += static_cast<std::int64_t>(line.size()) + 1;
      last_written_ = row_step;
    }
  } else {
    buffer_ = header;
  }
  if (::ftruncate(file_, kept) != 0 || ::lseek(file_, kept, SEEK_SET) != kept) {
    const std::string reason = std::strerror(errno);
    if (kept > 0) throw StorageError(path_ + " cannot be shortened (" + reason + "). Check its permissions.");
  }
}

void TrajectoryWriter::sync() {
  flush();
  ::fsync(file_);
}

TrajectoryWriter::~TrajectoryWriter() {
  try {
    flush();
  } catch (const Error&) {
    // The run is failing already; whole lines written before stay as they are.
  }
  ::close(file_);
}

void TrajectoryWriter::observe(const StepRecord& record) {
  const bool sampled = every_steps_ > 0 && record.step % every_steps_ == 0 && record.step >= sample_from_;
  if (sampled || last_written_ < 0) append_rows(record);
}

void TrajectoryWriter::finish(const StepRecord& last) {
  if (last_written_ != last.step) append_rows(last);
  flush();
}

void TrajectoryWriter::append_rows(const StepRecord& record) {
  const Kinematics& state = record.kinematics;
  for (Eigen::Index body = 0; body < state.bodies(); ++body) {
    append(buffer_, record.step);
    buffer_ += ',';
    append(buffer_, static_cast<double>(record.step) * step_s_);
    buffer_ += ',' + body_names_[static_cast<std::size_t>(body)];
    append_all(buffer_, state.position_m.col(body));
    append_all(buffer_, state.orientation_wxyz.col(body));
    append_all(buffer_, state.velocity_m_per_s.col(body));
    append_all(buffer_, state.angular_velocity_rad_per_s.col(body));
    append_all(buffer_, record.applied.force_N.col(body));
    append_all(buffer_, record.applied.torque_N_m.col(body));
    append_all(buffer_, record.driving_N.col(body));
    buffer_ += '\n';
  }
  last_written_ = record.step;
  constexpr std::size_t most_buffered = std::size_t{1} << 20;
  const bool due = std::chrono::steady_clock::now() - flushed_ >= std::chrono::seconds(1);
  if (due || buffer_.size() > most_buffered) flush();
}

void TrajectoryWriter::flush() {
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

}  // namespace copepod::coupler
