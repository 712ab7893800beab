#include "observers/trajectory_writer.hpp"

#include <array>
#include <bit>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "system/durable_file.hpp"

namespace copepod::coupler {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are announced as little-endian");

TrajectoryFile csv_trajectory(const std::string& path, const std::vector<std::string>& body_names,
                              const std::optional<TableEnd>& end) {
  auto file = std::make_unique<CsvFile>(
      path,
      "step,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_per_s,vy_m_per_s,vz_m_per_s,wx_rad_per_s,wy_rad_per_s,"
      "wz_rad_per_s,fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,drive_fx_N,drive_fy_N,drive_fz_N",
      end);
  std::vector<std::string> names;
  names.reserve(body_names.size());
  for (const std::string& name : body_names) names.push_back(csv_field(name));
  const auto add = [&to = *file, names, row = std::string()](const StepRecord& record, double time_s) mutable {
    const Kinematics& state = record.kinematics;
    for (Eigen::Index body = 0; body < state.bodies(); ++body) {
      row.clear();
      append(row, record.step);
      append_all(row, time_s);
      row += ',' + names[body];
      append_all(row, state.position_m.col(body), state.orientation_wxyz.col(body), state.velocity_m_per_s.col(body),
                 state.angular_velocity_rad_per_s.col(body), record.applied.force_N.col(body),
                 record.applied.torque_N_m.col(body), record.drive.force_N.col(body));
      to.add(row);
    }
  };
  return {std::move(file), add};
}

/// A structured type of NumPy: step, time, and an array of shape (bodies, components) for each quantity.
std::string type_of_sample(std::size_t bodies) {
  std::string type = "[('step', '<i8'), ('time_s', '<f8')";
  for (const char* quantity : {"position_m", "orientation_wxyz", "velocity_m_per_s", "angular_velocity_rad_per_s",
                               "force_N", "torque_N_m", "drive_N"}) {
    const char* components = std::string_view(quantity) == "orientation_wxyz" ? "4" : "3";
    type += fmt::format(", ('{}', '<f8', ({}, {}))", quantity, bodies, components);
  }
  return type + "]";
}

TrajectoryFile npy_trajectory(const std::string& file_path, const std::vector<std::string>& body_names,
                              const std::optional<TableEnd>& end) {
  constexpr std::size_t numbers = 22;  // of a body in a sample
  const std::filesystem::path path = file_path;
  auto file = std::make_unique<NpyFile>(path, type_of_sample(body_names.size()),
                                        sizeof(std::int64_t) + (1 + numbers * body_names.size()) * sizeof(double), end);
  std::string lines;
  for (const std::string& name : body_names) lines += name + '\n';
  write_durably(path.parent_path() / (path.stem().string() + "_names.txt"), lines);
  const auto add = [&to = *file](const StepRecord& record, double time_s) {
    const Kinematics& state = record.kinematics;
    const auto bytes = [](const auto& matrix) {
      return std::as_bytes(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
    };
    to.add(std::array{std::as_bytes(std::span(&record.step, 1)), std::as_bytes(std::span(&time_s, 1)),
                      bytes(state.position_m), bytes(state.orientation_wxyz), bytes(state.velocity_m_per_s),
                      bytes(state.angular_velocity_rad_per_s), bytes(record.applied.force_N),
                      bytes(record.applied.torque_N_m), bytes(record.drive.force_N)});
  };
  return {std::move(file), add};
}

std::string header_of(const std::vector<std::string>& names) {
  std::string header = "step,time_s";
  for (const std::string& name : names) header += ',' + csv_field(name);
  return header;
}

}  // namespace

TrajectoryWriter::TrajectoryWriter(const std::string& path, const std::vector<std::string>& body_names, double step_s,
                                   std::int64_t every_steps, std::int64_t sample_from,
                                   const std::optional<TableEnd>& end)
    : step_s_(step_s),
      every_steps_(every_steps),
      sample_from_(sample_from),
      last_written_(end ? 0 : -1),  // that of the first step is there
      file_((path.ends_with(".npy") ? npy_trajectory : csv_trajectory)(path, body_names, end)) {}

void TrajectoryWriter::observe(const StepRecord& record) {
  const bool sampled = every_steps_ > 0 && record.step % every_steps_ == 0 && record.step >= sample_from_;
  if (sampled || last_written_ < 0) add(record);
}

void TrajectoryWriter::finish(const StepRecord& last) {
  if (last_written_ != last.step) add(last);
  file_.table->flush();
}

void TrajectoryWriter::add(const StepRecord& record) {
  file_.add(record, static_cast<double>(record.step) * step_s_);
  last_written_ = record.step;
}

SampleWriter::SampleWriter(const std::string& path, const std::vector<std::string>& names, double step_s, Values values,
                           const std::optional<TableEnd>& end)
    : step_s_(step_s), values_(std::move(values)), file_(path, header_of(names), end) {}

void SampleWriter::observe(const StepRecord& record) {
  const Eigen::VectorXd values = values_(record);
  if (values.size() == 0) return;
  std::string row;
  append(row, record.step);
  append_all(row, static_cast<double>(record.step) * step_s_, values);
  file_.add(row);
}

ObstacleWriter::ObstacleWriter(const std::vector<ObstacleSpecification>& obstacles,
                               std::unique_ptr<TrajectoryWriter> writer)
    : writer_(std::move(writer)) {
  places_.resize(obstacles.size());
  places_.velocity_m_per_s.setZero();
  places_.angular_velocity_rad_per_s.setZero();
  no_loads_.force_N.setZero(3, places_.bodies());
  no_loads_.torque_N_m = no_loads_.force_N;
  for (Eigen::Index i = 0; i < places_.bodies(); ++i) {
    places_.position_m.col(i) = obstacles[i].position_m;
    places_.orientation_wxyz.col(i) = obstacles[i].orientation_wxyz;
  }
}

}  // namespace copepod::coupler
