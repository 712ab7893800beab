#include "observers/trajectory_writer.hpp"

#include <array>
#include <span>
#include <utility>

#include "storage/csv_file.hpp"
#include "storage/hdf5_table.hpp"

namespace copepod::coupler {
namespace {

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

class Hdf5Trajectory final : public TrajectoryFile {
 public:
  Hdf5Trajectory(const std::string& path, const std::vector<std::string>& body_names,
                 const std::optional<TableEnd>& end)
      : file_(path,
              {{"step", Hdf5Column::Kind::whole_number},
               {"time_s"},
               {"position_m", Hdf5Column::Kind::real, 3},
               {"orientation_wxyz", Hdf5Column::Kind::real, 4},
               {"velocity_m_per_s", Hdf5Column::Kind::real, 3},
               {"angular_velocity_rad_per_s", Hdf5Column::Kind::real, 3},
               {"force_N", Hdf5Column::Kind::real, 3},
               {"torque_N_m", Hdf5Column::Kind::real, 3},
               {"drive_N", Hdf5Column::Kind::real, 3}},
              "body", body_names, end) {}

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
  Hdf5Table file_;
};

std::unique_ptr<TrajectoryFile> make_file(const std::string& path, const std::vector<std::string>& body_names,
                                          const std::optional<TableEnd>& end) {
  if (path.ends_with(hdf5_suffix)) return std::make_unique<Hdf5Trajectory>(path, body_names, end);
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
