#include "analysis/cycle.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "analysis/rigid_fit.hpp"
#include "analysis/swimmer_figures.hpp"

namespace copepod::coupler {

CycleFigures evaluate(const Cycle& cycle, const Group& group, const FluidCase& fluid, double step_s) {
  CycleFigures figures;
  figures.axis = cycle.turned * group.axis;
  figures.velocity_m_per_s = cycle.translation_m / (static_cast<double>(group.period_steps) * step_s);
  figures.along_m_per_s = figures.velocity_m_per_s.dot(figures.axis);
  figures.across_m_per_s = figures.velocity_m_per_s - figures.along_m_per_s * figures.axis;
  figures.rotation_rad = rotation_vector(cycle.rotation);
  figures.tilt_rad = std::atan2(group.axis.cross(figures.axis).norm(), group.axis.dot(figures.axis));
  const double viscosity_m2_per_s = fluid.kinematic_viscosity_m2_per_s, speed = figures.velocity_m_per_s.norm();
  if (viscosity_m2_per_s <= 0.0) return figures;
  figures.Re = speed * group.length_m / viscosity_m2_per_s;
  figures.efficiency = efficiency(group.radius_m, speed, cycle.power_W, fluid);
  return figures;
}

double change_of_motion(const Cycle& before, const Cycle& after, double length_m) {
  const auto gained = [&](const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
    return (after.turned.transpose() * second - before.turned.transpose() * first).norm();
  };
  const Eigen::Vector3d turned = rotation_vector(after.rotation);
  const double motion = std::max(after.translation_m.norm() / length_m, turned.norm());
  if (motion <= rest_in_a_cycle) return 0.0;
  return std::max(gained(before.translation_m, after.translation_m) / length_m,
                  gained(rotation_vector(before.rotation), turned)) /
         motion;
}

CycleChange change(const Cycle& before, const Cycle& after, double length_m) {
  const auto relative = [&](const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                            double unit) -> std::optional<double> {
    if (second.norm() <= rest_in_a_cycle * unit) return {};
    return (after.turned.transpose() * second - before.turned.transpose() * first).norm() / second.norm();
  };
  return {relative(before.translation_m, after.translation_m, length_m),
          relative(rotation_vector(before.rotation), rotation_vector(after.rotation), 1.0)};
}

}  // namespace copepod::coupler
