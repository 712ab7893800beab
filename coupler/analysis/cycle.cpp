#include "analysis/cycle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include <Eigen/Geometry>

#include "analysis/rigid_fit.hpp"
#include "analysis/swimmer_figures.hpp"

namespace copepod::coupler {

namespace {

/// Velocity after Golestanian and Ajdari along the own axis [docs/theory.md, (C9)], of three bodies whose arms lead
/// from the trailing one to the middle one, and from there to the leading one.
std::optional<double> golestanian_ajdari_m_per_s(const Cycle& cycle, const Group& group, double step_s) {
  if (group.bodies.size() != 3 || group.arms.size() != 2) return {};
  const Eigen::Matrix3Xd places_m = group.placed_m.colwise() - group.placed_m.rowwise().mean();
  const Eigen::RowVectorXd along_m = group.axis.transpose() * places_m;
  if ((places_m - group.axis * along_m).norm() > 1e-6 * group.length_m) return {};
  std::array<std::size_t, 3> order{0, 1, 2};
  std::ranges::sort(order, {}, [&](std::size_t body) { return along_m[static_cast<Eigen::Index>(body)]; });
  const auto arm_between = [&](std::size_t first, std::size_t second) {
    const std::set ends{group.bodies[first], group.bodies[second]};
    return std::ranges::find(group.arms, ends, [](const auto& arm) { return std::set{arm[0], arm[1]}; });
  };
  const auto trailing = arm_between(order[0], order[1]), leading = arm_between(order[1], order[2]);
  if (trailing == group.arms.end() || leading == group.arms.end()) return {};
  const Eigen::Vector3d one = cycle.arms.col(trailing - group.arms.begin());
  const Eigen::Vector3d two = cycle.arms.col(leading - group.arms.begin());
  const double K_per_m =
      geometrical_factor_per_m({group.radii_m[0], group.radii_m[1], group.radii_m[2]}, {one[0], two[0]});
  const double omega_rad_per_s = 2.0 * std::numbers::pi / (static_cast<double>(group.period_steps) * step_s);
  return K_per_m * one[1] * two[1] * omega_rad_per_s * std::sin(one[2] - two[2]);
}

}  // namespace

CycleFigures evaluate(const Cycle& cycle, const Group& group, const FluidCase& fluid, double step_s) {
  CycleFigures figures;
  figures.axis = cycle.turned * group.axis;
  figures.velocity_m_per_s = cycle.translation_m / (static_cast<double>(group.period_steps) * step_s);
  figures.along_m_per_s = figures.velocity_m_per_s.dot(figures.axis);
  figures.across_m_per_s = figures.velocity_m_per_s - figures.along_m_per_s * figures.axis;
  figures.rotation_rad = rotation_vector(cycle.rotation);
  figures.tilt_rad = std::atan2(group.axis.cross(figures.axis).norm(), group.axis.dot(figures.axis));
  figures.u_GA_m_per_s = golestanian_ajdari_m_per_s(cycle, group, step_s);
  const double viscosity_m2_per_s = fluid.kinematic_viscosity_m2_per_s, speed = figures.velocity_m_per_s.norm();
  if (viscosity_m2_per_s <= 0.0) return figures;
  figures.Re = speed * group.length_m / viscosity_m2_per_s;
  const double radius_m = std::accumulate(group.radii_m.begin(), group.radii_m.end(), 0.0);
  figures.efficiency = efficiency(radius_m, speed, cycle.power_W, fluid);
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
