#include "analysis/cycle_table.hpp"

#include <algorithm>

namespace copepod::coupler {
namespace {

std::int64_t most_arms(const std::vector<Group>& groups) {
  std::size_t most = 0;
  for (const Group& group : groups) most = std::max(most, group.arms.size());
  return static_cast<std::int64_t>(most);
}

std::string header(const std::vector<Group>& groups) {
  std::string text =
      "swimmer,cycle,start_step,start_s,x_m,y_m,z_m,axis_x,axis_y,axis_z,tilt_rad,u_along_m_per_s,u_across_m_per_s,"
      "ux_m_per_s,uy_m_per_s,uz_m_per_s,rotation_x_rad,rotation_y_rad,rotation_z_rad,power_W,dissipation_W,efficiency,"
      "Re";
  for (std::int64_t arm = 0; arm < most_arms(groups); ++arm) {
    const std::string name = ",arm" + std::to_string(arm);
    text += name + "_mean_m" + name + "_amplitude_m" + name + "_phase_rad";
  }
  return text;
}

void append_optional(std::string& row, const std::optional<double>& value) {
  row += ',';
  if (value) append(row, *value);
}

}  // namespace

CycleTable::CycleTable(const std::string& path, const std::vector<Group>& groups, const FluidCase& fluid, double step_s,
                       const std::optional<TableEnd>& end)
    : fluid_(fluid), step_s_(step_s), most_arms_(most_arms(groups)), file_(path, header(groups), end) {}

void CycleTable::add(const Group& group, const Cycle& cycle) {
  const CycleFigures figures = evaluate(cycle, group, fluid_, step_s_);
  const std::int64_t start = cycle.number * group.period_steps;
  std::string row = csv_field(group.name);
  append_all(row, Eigen::Matrix<std::int64_t, 2, 1>(cycle.number, start));
  append_all(row, Eigen::Matrix<double, 1, 1>(static_cast<double>(start) * step_s_));
  append_all(row, cycle.centroid_m);
  append_all(row, figures.axis);
  append_all(row, Eigen::Vector3d(figures.tilt_rad, figures.along_m_per_s, figures.across_m_per_s.norm()));
  append_all(row, figures.velocity_m_per_s);
  append_all(row, figures.rotation_rad);
  append_all(row, Eigen::Vector2d(cycle.power_W, cycle.dissipation_W));
  append_optional(row, figures.efficiency);
  append_optional(row, figures.Re);
  for (Eigen::Index arm = 0; arm < cycle.arms.cols(); ++arm) append_all(row, cycle.arms.col(arm));
  row.append(static_cast<std::size_t>(3 * (most_arms_ - cycle.arms.cols())), ',');
  file_.add(row);
  file_.flush();
}

}  // namespace copepod::coupler
