#include "analysis/cycle_observer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "analysis/groups.hpp"
#include "analysis/rigid_fit.hpp"
#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

Eigen::Matrix3Xd positions_m(const Group& group, const StepRecord& record) {
  return record.kinematics.position_m(Eigen::all, group.bodies);
}

double arm_m(const std::array<int, 2>& arm, const StepRecord& record) {
  return (record.kinematics.position_m.col(arm[1]) - record.kinematics.position_m.col(arm[0])).norm();
}

/// Least squares on T equidistant samples of one whole period: 1, cos ωt and sin ωt are orthogonal there, so
///   l̄ = Σl/T,  A = 2 Σ l cos ωt / T,  B = 2 Σ l sin ωt / T,  d = √(A² + B²),  φ = atan2(−B, A)      (C8)
Eigen::Vector3d fitted_arm(const CycleSums& sums, Eigen::Index arm) {
  const auto samples = static_cast<double>(sums.samples);
  const double a = 2.0 * sums.arm_cosine_m[arm] / samples;
  const double b = 2.0 * sums.arm_sine_m[arm] / samples;
  return {sums.first_arm_m[arm] + sums.arm_m[arm] / samples, std::hypot(a, b), std::atan2(-b, a)};
}

bool fits(const Cycle& cycle, const Group& group) {
  const auto bodies = static_cast<Eigen::Index>(group.bodies.size());
  return cycle.number < 0 ||
         (cycle.displacement_m.cols() == bodies && cycle.arms.cols() == static_cast<Eigen::Index>(group.arms.size()) &&
          cycle.max_speed_m_per_s.size() == bodies && cycle.max_speed_along_m_per_s.size() == bodies);
}

/// Whether these can be the sums before a step, the first excepted.
bool fits(const CycleSums& sums, const Group& group, std::int64_t step, std::int64_t first_step) {
  if (!fits(sums.last, group) || !fits(sums.before_last, group)) return false;
  const std::int64_t number = group.period_steps > 0 ? (step - 1) / group.period_steps : -1;
  const bool began_before = number * group.period_steps < first_step;
  if (number < group.first_cycle || number >= group.stop_cycle || began_before) return sums.number < 0;
  const auto bodies = static_cast<Eigen::Index>(group.bodies.size());
  const auto arms = static_cast<Eigen::Index>(group.arms.size());
  return sums.number == number && sums.samples == step - number * group.period_steps &&
         sums.first_position_m.cols() == bodies && sums.max_speed_m_per_s.size() == bodies &&
         sums.max_speed_along_m_per_s.size() == bodies && sums.first_arm_m.size() == arms &&
         sums.arm_m.size() == arms && sums.arm_cosine_m.size() == arms && sums.arm_sine_m.size() == arms &&
         sums.power_as_in_paper_W.has_value() == static_cast<bool>(group.power_as_in_paper_W);
}

}  // namespace

CycleObserver::CycleObserver(std::vector<Group> groups) : groups_(std::move(groups)), sums_(groups_.size()) {}

void CycleObserver::observe(const StepRecord& record) {
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const Group& group = groups_[i];
    CycleSums& sums = sums_[i];
    if (group.period_steps == 0) continue;
    if (sums.samples == group.period_steps) close(group, sums, record);
    if (sums.number < 0 && record.step % group.period_steps == 0) open(group, sums, record);
    if (sums.number >= 0) sample(group, sums, record);
  }
}

void CycleObserver::finish(const StepRecord& last) {
  end_position_m_ = last.kinematics.position_m;
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    if (sums_[i].number >= 0 && sums_[i].samples == groups_[i].period_steps) close(groups_[i], sums_[i], last);
  }
}

bool CycleObserver::is_periodic(double tolerance) const {
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    if (groups_[i].period_steps == 0) continue;
    const auto& [last, before] = std::tie(sums_[i].last, sums_[i].before_last);
    if (before.number < 0 || !(change_of_motion(before, last, groups_[i].length_m) <= tolerance)) return false;
  }
  return have_cycles(groups_);
}

void CycleObserver::open(const Group& group, CycleSums& sums, const StepRecord& record) {
  const std::int64_t number = record.step / group.period_steps;
  if (number < group.first_cycle || number >= group.stop_cycle) return;
  sums.number = number;
  sums.first_position_m = positions_m(group, record);
  if (sums.last.number < 0) sums.turned = fit_rigid_motion(group.placed_m, sums.first_position_m).rotation;
  const auto arms = static_cast<Eigen::Index>(group.arms.size());
  sums.first_arm_m.resize(arms);
  for (Eigen::Index arm = 0; arm < arms; ++arm)
    sums.first_arm_m[arm] = arm_m(group.arms[static_cast<std::size_t>(arm)], record);
  for (Eigen::VectorXd* sum : {&sums.arm_m, &sums.arm_cosine_m, &sums.arm_sine_m}) sum->setZero(arms);
  for (Eigen::VectorXd* speed : {&sums.max_speed_m_per_s, &sums.max_speed_along_m_per_s})
    speed->setZero(static_cast<Eigen::Index>(group.bodies.size()));
  sums.power_W = sums.dissipation_W = 0.0;
  sums.power_as_in_paper_W = group.power_as_in_paper_W ? std::optional(0.0) : std::nullopt;
}

void CycleObserver::set_phase(std::int64_t within, std::int64_t period_steps) {
  if (within == phase_within_ && period_steps == phase_period_) return;
  const double phase = 2.0 * std::numbers::pi * static_cast<double>(within) / static_cast<double>(period_steps);
  cosine_ = std::cos(phase);
  sine_ = std::sin(phase);
  phase_within_ = within;
  phase_period_ = period_steps;
}

void CycleObserver::sample(const Group& group, CycleSums& sums, const StepRecord& record) {
  set_phase(sums.samples, group.period_steps);
  for (std::size_t i = 0; i < group.arms.size(); ++i) {
    const auto arm = static_cast<Eigen::Index>(i);
    const double change = arm_m(group.arms[i], record) - sums.first_arm_m[arm];
    sums.arm_m[arm] += change;
    sums.arm_cosine_m[arm] += change * cosine_;
    sums.arm_sine_m[arm] += change * sine_;
  }
  const Eigen::Vector3d axis = sums.turned * group.axis;
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    const int body = group.bodies[i];
    const Eigen::Vector3d v = record.kinematics.velocity_m_per_s.col(body);
    const Eigen::Vector3d w = record.kinematics.angular_velocity_rad_per_s.col(body);
    sums.power_W += record.drive.force_N.col(body).dot(v) + record.drive.torque_N_m.col(body).dot(w);
    sums.dissipation_W -= record.applied.force_N.col(body).dot(v) + record.applied.torque_N_m.col(body).dot(w);
    double& fastest = sums.max_speed_m_per_s[static_cast<Eigen::Index>(i)];
    double& fastest_along = sums.max_speed_along_m_per_s[static_cast<Eigen::Index>(i)];
    fastest = std::max(fastest, v.norm());
    fastest_along = std::max(fastest_along, std::abs(v.dot(axis)));
  }
  if (sums.power_as_in_paper_W) *sums.power_as_in_paper_W += group.power_as_in_paper_W(record, axis);
  ++sums.samples;
}

void CycleObserver::close(const Group& group, CycleSums& sums, const StepRecord& record) {
  const auto samples = static_cast<double>(sums.samples);
  const Eigen::Matrix3Xd position_m = positions_m(group, record);
  const RigidMotion motion = fit_rigid_motion(sums.first_position_m, position_m);
  Cycle cycle;
  cycle.number = sums.number;
  cycle.centroid_m = sums.first_position_m.rowwise().mean();
  cycle.turned = sums.turned;
  cycle.translation_m = motion.translation_m;
  cycle.rotation = motion.rotation;
  cycle.displacement_m = position_m - sums.first_position_m;
  cycle.arms.resize(3, sums.arm_m.size());
  for (Eigen::Index arm = 0; arm < sums.arm_m.size(); ++arm) cycle.arms.col(arm) = fitted_arm(sums, arm);
  cycle.power_W = sums.power_W / samples;
  cycle.dissipation_W = sums.dissipation_W / samples;
  if (sums.power_as_in_paper_W) cycle.power_as_in_paper_W = *sums.power_as_in_paper_W / samples;
  cycle.max_speed_m_per_s = sums.max_speed_m_per_s;
  cycle.max_speed_along_m_per_s = sums.max_speed_along_m_per_s;
  if (table_ != nullptr) table_->add(group, cycle);
  if (sums.last.number >= 0) {
    const Eigen::Index kept = std::min<Eigen::Index>(sums.latest_along_m.size(), 4);
    Eigen::VectorXd latest_m(kept + 1);
    latest_m << sums.latest_along_m.tail(kept), cycle.translation_m.dot(sums.turned * group.axis);
    sums.latest_along_m = latest_m;
  }
  sums.before_last = std::exchange(sums.last, std::move(cycle));
  sums.turned = motion.rotation * sums.turned;
  sums.number = -1;
  sums.samples = 0;
}

void CycleObserver::restore(const std::vector<CycleSums>& sums, std::int64_t step, std::int64_t first_step) {
  if (!std::equal(sums.begin(), sums.end(), groups_.begin(), groups_.end(),
                  [&](const CycleSums& each, const Group& group) { return fits(each, group, step, first_step); })) {
    throw StorageError(
        "the checkpoint has the analysis of other swimmers than the case, or of another step (it is of another case). "
        "Use another run directory.");
  }
  sums_ = sums;
}

}  // namespace copepod::coupler
