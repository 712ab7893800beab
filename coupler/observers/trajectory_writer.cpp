#include "observers/trajectory_writer.hpp"

namespace copepod::coupler {
namespace {

constexpr const char* columns =
    "step,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_per_s,vy_m_per_s,vz_m_per_s,wx_rad_per_s,wy_rad_per_s,wz_"
    "rad_per_s,"
    "fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,drive_fx_N,drive_fy_N,drive_fz_N";

}  // namespace

TrajectoryWriter::TrajectoryWriter(const std::string& path, std::vector<std::string> body_names, double step_s,
                                   std::int64_t every_steps, std::int64_t sample_from,
                                   const std::optional<TableEnd>& end)
    : body_names_(std::move(body_names)),
      step_s_(step_s),
      every_steps_(every_steps),
      sample_from_(sample_from),
      last_written_(end ? 0 : -1),  // that of the first step is there
      file_(path, columns, end) {
  for (std::string& name : body_names_) name = csv_field(name);
}

void TrajectoryWriter::observe(const StepRecord& record) {
  const bool sampled = every_steps_ > 0 && record.step % every_steps_ == 0 && record.step >= sample_from_;
  if (sampled || last_written_ < 0) add_rows(record);
}

void TrajectoryWriter::finish(const StepRecord& last) {
  if (last_written_ != last.step) add_rows(last);
  file_.flush();
}

void TrajectoryWriter::add_rows(const StepRecord& record) {
  const Kinematics& state = record.kinematics;
  for (Eigen::Index body = 0; body < state.bodies(); ++body) {
    row_.clear();
    append(row_, record.step);
    row_ += ',';
    append(row_, static_cast<double>(record.step) * step_s_);
    row_ += ',' + body_names_[static_cast<std::size_t>(body)];
    append_all(row_, state.position_m.col(body));
    append_all(row_, state.orientation_wxyz.col(body));
    append_all(row_, state.velocity_m_per_s.col(body));
    append_all(row_, state.angular_velocity_rad_per_s.col(body));
    append_all(row_, record.applied.force_N.col(body));
    append_all(row_, record.applied.torque_N_m.col(body));
    append_all(row_, record.drive.force_N.col(body));
    file_.add(row_);
  }
  last_written_ = record.step;
}

}  // namespace copepod::coupler
