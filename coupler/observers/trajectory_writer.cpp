#include "observers/trajectory_writer.hpp"

#include <array>
#include <bit>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "storage/table_file.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are announced as little-endian");

class CsvTrajectory final : public TrajectoryFile {
 public:
  CsvTrajectory(const std::string& path, const std::vector<std::string>& body_names, const std::optional<TableEnd>& end)
      : file_(path,
              "step,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_per_s,vy_m_per_s,vz_m_per_s,wx_rad_per_s,wy_rad_per_s,"
              "wz_rad_per_s,fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,drive_fx_N,drive_fy_N,drive_fz_N",
              end) {
    for (const std::string& name : body_names) body_names_.push_back(csv_field(name));
  }

  void add(const StepRecord& record, double time_s) override {
    const Kinematics& state = record.kinematics;
    for (Eigen::Index body = 0; body < state.bodies(); ++body) {
      row_.clear();
      append(row_, record.step);
      row_ += ',';
      append(row_, time_s);
      row_ += ',' + body_names_[body];
      append_all(row_, state.position_m.col(body));
      append_all(row_, state.orientation_wxyz.col(body));
      append_all(row_, state.velocity_m_per_s.col(body));
      append_all(row_, state.angular_velocity_rad_per_s.col(body));
      append_all(row_, record.applied.force_N.col(body));
      append_all(row_, record.applied.torque_N_m.col(body));
      append_all(row_, record.drive.force_N.col(body));
      file_.add(row_);
    }
  }
  TableFile& table() override { return file_; }

 private:
  std::vector<std::string> body_names_;
  std::string row_;
  CsvFile file_;
};

class NpyTrajectory final : public TrajectoryFile {
 public:
  NpyTrajectory(const std::string& path, const std::vector<std::string>& body_names, const std::optional<TableEnd>& end)
      : file_(path, type_of_sample(body_names.size()),
              sizeof(std::int64_t) + (1 + numbers * body_names.size()) * sizeof(double), end) {
    std::string lines;
    for (const std::string& name : body_names) lines += name + '\n';
    write_durably(names_of(path), lines);
  }

  void add(const StepRecord& record, double time_s) override {
    const Kinematics& state = record.kinematics;
    const auto bytes = [](const auto& matrix) {
      return std::as_bytes(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
    };
    file_.add(std::array{std::as_bytes(std::span(&record.step, 1)), std::as_bytes(std::span(&time_s, 1)),
                         bytes(state.position_m), bytes(state.orientation_wxyz), bytes(state.velocity_m_per_s),
                         bytes(state.angular_velocity_rad_per_s), bytes(record.applied.force_N),
                         bytes(record.applied.torque_N_m), bytes(record.drive.force_N)});
  }
  TableFile& table() override { return file_; }

 private:
  static constexpr std::size_t numbers = 22;  ///< of a body in a sample

  /// A structured type of NumPy: step, time, and an array of shape (bodies, components) for each quantity.
  static std::string type_of_sample(std::size_t bodies) {
    std::string type = "[('step', '<i8'), ('time_s', '<f8')";
    for (const char* quantity : {"position_m", "orientation_wxyz", "velocity_m_per_s", "angular_velocity_rad_per_s",
                                 "force_N", "torque_N_m", "drive_N"}) {
      const char* components = std::string_view(quantity) == "orientation_wxyz" ? "4" : "3";
      type += fmt::format(", ('{}', '<f8', ({}, {}))", quantity, bodies, components);
    }
    return type + "]";
  }

  static std::string names_of(const std::filesystem::path& path) {
    return path.parent_path() / (path.stem().string() + "_names.txt");
  }

  NpyFile file_;
};

std::unique_ptr<TrajectoryFile> make_file(const std::string& path, const std::vector<std::string>& body_names,
                                          const std::optional<TableEnd>& end) {
  if (path.ends_with(".npy")) return std::make_unique<NpyTrajectory>(path, body_names, end);
  return std::make_unique<CsvTrajectory>(path, body_names, end);
}

}  // namespace

TrajectoryWriter::TrajectoryWriter(const std::string& path, const std::vector<std::string>& body_names, double step_s,
                                   std::int64_t every_steps, std::int64_t sample_from,
                                   const std::optional<TableEnd>& end)
    : step_s_(step_s),
      every_steps_(every_steps),
      sample_from_(sample_from),
      last_written_(end ? 0 : -1),  // that of the first step is there
      file_(make_file(path, body_names, end)) {}

void TrajectoryWriter::observe(const StepRecord& record) {
  const bool sampled = every_steps_ > 0 && record.step % every_steps_ == 0 && record.step >= sample_from_;
  if (sampled || last_written_ < 0) add(record);
}

void TrajectoryWriter::finish(const StepRecord& last) {
  if (last_written_ != last.step) add(last);
  file_->table().flush();
}

void TrajectoryWriter::add(const StepRecord& record) {
  file_->add(record, static_cast<double>(record.step) * step_s_);
  last_written_ = record.step;
}

ObstacleWriter::ObstacleWriter(const std::vector<ObstacleSpecification>& obstacles,
                               std::unique_ptr<TrajectoryWriter> writer)
    : writer_(std::move(writer)) {
  places_.resize(static_cast<Eigen::Index>(obstacles.size()));
  places_.velocity_m_per_s.setZero();
  places_.angular_velocity_rad_per_s.setZero();
  no_drive_.force_N.setZero(3, places_.bodies());
  for (Eigen::Index i = 0; i < places_.bodies(); ++i) {
    places_.position_m.col(i) = obstacles[i].position_m;
    places_.orientation_wxyz.col(i) = obstacles[i].orientation_wxyz;
  }
}

}  // namespace copepod::coupler
