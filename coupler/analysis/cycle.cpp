#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "analysis/cycle_observer.hpp"
#include "analysis/swimmer_figures.hpp"
#include "geometry/rotation.hpp"

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

/// Whether points about their centroid leave a line by less than a thousandth of their extent along it.
bool is_row(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3d moments = points * points.transpose();
  const Eigen::Vector3d squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvalues();
  return squares[1] <= 1e-6 * squares[2];
}

/// Shortest rotation from one unit vector to another; a half turn about any perpendicular axis for opposite ones.
///   R = I + [w]ₓ + [w]ₓ² / (1 + c),   w = from × to,   c = from · to
Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const double c = from.dot(to);
  if (c < -1.0 + 1e-12) {
    const Eigen::Vector3d n = from.unitOrthogonal();
    return 2.0 * n * n.transpose() - Eigen::Matrix3d::Identity();
  }
  const Eigen::Vector3d w = from.cross(to);
  Eigen::Matrix3d cross;
  cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return Eigen::Matrix3d::Identity() + cross + cross * cross / (1.0 + c);
}

/// Velocity after Golestanian and Ajdari along the own axis [docs/theory.md, (C9)], of three bodies whose arms lead
/// from the trailing one to the middle one, and from there to the leading one.
std::optional<double> golestanian_ajdari_m_per_s(const Cycle& cycle, const Group& group, double step_s) {
  if (group.bodies.size() != 3 || group.arms.size() != 2) return {};
  const Eigen::Matrix3Xd places_m = group.placed_m.colwise() - group.placed_m.rowwise().mean();
  const Eigen::RowVectorXd along_m = group.axis.transpose() * places_m;
  if ((places_m - group.axis * along_m).norm() > 1e-6 * group.length_m) return {};
  std::array<std::size_t, 3> order{0, 1, 2};
  std::ranges::sort(order, {}, [&](std::size_t body) { return along_m[body]; });
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

CycleTable::CycleTable(const std::string& path, const std::vector<Group>& groups, const FluidCase& fluid, double step_s,
                       const std::optional<TableEnd>& end)
    : fluid_(fluid), step_s_(step_s), most_arms_(most_arms(groups)), file_(path, header(groups), end) {}

void CycleTable::add(const Group& group, const Cycle& cycle) {
  const CycleFigures figures = evaluate(cycle, group, fluid_, step_s_);
  const std::int64_t start = cycle.number * group.period_steps;
  std::string row = csv_field(group.name);
  append_all(row, cycle.number, start, static_cast<double>(start) * step_s_, cycle.centroid_m, figures.axis,
             figures.tilt_rad, figures.along_m_per_s, figures.across_m_per_s.norm(), figures.velocity_m_per_s,
             figures.rotation_rad, cycle.power_W, cycle.dissipation_W, figures.efficiency, figures.Re);
  append_all(row, cycle.arms.reshaped());
  row.append(3 * (most_arms_ - cycle.arms.cols()), ',');
  file_.add(row);
  file_.flush();
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(rotation)};
  return turn.angle() * turn.axis();
}

RigidMotion fit_rigid_motion(const Eigen::Matrix3Xd& before, const Eigen::Matrix3Xd& after) {
  const Eigen::Vector3d from = before.rowwise().mean(), to = after.rowwise().mean();
  RigidMotion motion;
  motion.translation_m = to - from;
  const Eigen::Matrix3Xd p = before.colwise() - from, q = after.colwise() - to;
  const Eigen::Matrix3d covariance = p * q.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d &U = svd.matrixU(), &V = svd.matrixV();
  const Eigen::Vector3d& S = svd.singularValues();
  if (S[0] == 0.0) return motion;
  if (is_row(p) || is_row(q)) {
    motion.rotation = shortest_rotation(U.col(0), V.col(0));
    return motion;
  }
  const double handedness = (V * U.transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  motion.rotation = V * Eigen::Vector3d(1.0, 1.0, handedness).asDiagonal() * U.transpose();
  return motion;
}

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
