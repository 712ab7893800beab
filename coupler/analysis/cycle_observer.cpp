#include "analysis/cycle_observer.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>
#include <unordered_map>

#include "analysis/swimmer_figures.hpp"
#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::coupler {

namespace {

/// Half the extent of a body along a direction [m].
double half_extent_m(const BodySpecification& body, const Eigen::Vector3d& direction) {
  if (is_round(body.shape))
    return body.shape.radius_m +
           core_half_length_m(body.shape) * std::abs(z_axis(body.orientation_wxyz).dot(direction));
  const Eigen::Vector3d direction_B = rotation_matrix(body.orientation_wxyz).transpose() * direction;
  const auto solid = make_solid(body.shape);
  return 0.5 * (solid->support(direction_B) - solid->support(-direction_B)).dot(direction_B);
}

/// Greatest distance between the surfaces of two of the bodies, or a body's own extent along `axis` [m]. Bodies are
/// taken from the outermost inwards, until the spheres about the centroid that hold the remaining ones are too small.
double length_m(const std::vector<BodySpecification>& bodies, const Eigen::Matrix3Xd& placed_m,
                const Eigen::Vector3d& axis) {
  const Eigen::Vector3d centroid_m = placed_m.rowwise().mean();
  std::vector<std::pair<double, const BodySpecification*>> outermost;  // radius of the sphere that holds the body
  double length = 0.0;
  for (const BodySpecification& body : bodies) {
    length = std::max(length, 2.0 * half_extent_m(body, axis));
    outermost.emplace_back((body.position_m - centroid_m).norm() + bounding_radius_m(body.shape), &body);
  }
  std::ranges::sort(outermost, std::greater(), [](const auto& body) { return body.first; });
  for (std::size_t i = 0; i < outermost.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (outermost[i].first + outermost[j].first <= length) break;
      const BodySpecification &one = *outermost[j].second, &other = *outermost[i].second;
      const Eigen::Vector3d between_m = other.position_m - one.position_m;
      const double distance_m = between_m.norm();
      if (distance_m == 0.0) continue;
      const Eigen::Vector3d along = between_m / distance_m;
      length = std::max(length, half_extent_m(one, along) + distance_m + half_extent_m(other, along));
    }
  }
  return length;
}

/// Period and full cycles of what drives a group.
class DriveTiming {
 public:
  void add(const Signal& signal) {
    if (signal.period_steps == 0) return;
    periods_steps_.insert(signal.period_steps);
    start_step_ = std::min(start_step_, signal.start_step);
    stop_step_ = std::min(stop_step_, signal.stop_step);
  }

  /// @param given_steps  period that the case gives; 0: none
  void set_cycles(std::int64_t given_steps, Group& group) const {
    group.period_steps = given_steps > 0 || periods_steps_.empty() ? given_steps : common_period(group.note);
    if (group.period_steps == 0) {
      group.note = "without a periodic drive it has no cycles to measure";
      return;
    }
    const std::int64_t start_step = start_step_ == Signal::never ? 0 : start_step_;
    group.first_cycle = (start_step + group.period_steps - 1) / group.period_steps;
    group.stop_cycle = stop_step_ / group.period_steps;
    if (group.first_cycle >= group.stop_cycle)
      group.note = "its drive lasts for no whole cycle of the run (cycles start at multiples of the period)";
  }

 private:
  /// The least common multiple of all periods, or the longest of them if that takes too many of it.
  [[nodiscard]] std::int64_t common_period(std::string& note) const {
    constexpr std::int64_t most_of_the_longest = 10;
    const std::int64_t longest = *periods_steps_.rbegin();
    std::int64_t common = longest;
    for (const std::int64_t period : periods_steps_) {
      const std::int64_t times = period / std::gcd(common, period);
      if (times > most_of_the_longest * longest / common) {
        note = "its drives have different periods and no short common one; cycles are those of the longest, " +
               std::to_string(longest) + " steps";
        return longest;
      }
      common *= times;
    }
    if (periods_steps_.size() > 1)
      note = "its drives have different periods; cycles are those of their common one, " + std::to_string(common) +
             " steps";
    return common;
  }

  std::set<std::int64_t> periods_steps_;
  std::int64_t start_step_ = Signal::never, stop_step_ = Signal::never;
};

Group group_of(const std::string& name, const std::vector<int>& numbers, const Eigen::Vector3d& axis,
               const Assembly& assembly) {
  Group group;
  group.name = name;
  group.bodies = numbers;
  group.axis = axis;
  group.placed_m.resize(3, numbers.size());
  std::vector<BodySpecification> bodies;
  for (const int number : numbers) {
    const BodySpecification& body = bodies.emplace_back(assembly.bodies[number]);
    group.placed_m.col(group.body_names.size()) = body.position_m;
    group.body_names.push_back(body.name);
    group.radii_m.push_back(equivalent_radius_m(body.shape));
  }
  group.length_m = length_m(bodies, group.placed_m, axis);
  return group;
}

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

std::vector<Group> groups_of(const Case& the_case, const Assembly& assembly) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Swimmer& swimmer = the_case.swimmers[i];
    std::vector<int> bodies(swimmer.beads.size());
    std::iota(bodies.begin(), bodies.end(), assembly.first_bodies[i]);
    Group& group = groups.emplace_back(group_of(swimmer.name, bodies, z_axis(swimmer.orientation_wxyz), assembly));
    if (swimmer.three_beads && !swimmer.published.empty()) {
      group.power_as_in_paper_W = [stroke = swimmer.three_beads->stroke, first_body = bodies[0]](
                                      const StepRecord& record, const Eigen::Vector3d& axis) {
        return power_with_rounded_omega_W(stroke, first_body, axis, record);
      };
    }
  }
  for (std::size_t i = 0; i < the_case.groups.size(); ++i)
    groups.push_back(group_of(the_case.groups[i].name, assembly.groups[i], the_case.groups[i].axis, assembly));

  std::unordered_map<int, std::vector<std::size_t>> of_body;  // groups in ascending order
  for (std::size_t group = 0; group < groups.size(); ++group)
    for (const int body : groups[group].bodies) of_body[body].push_back(group);
  const auto of_both = [&](int body_A, int body_B) {
    std::vector<std::size_t> both;
    std::ranges::set_intersection(of_body[body_A], of_body[body_B], std::back_inserter(both));
    return both;
  };
  for (const SpringSpecification& spring : assembly.springs)
    for (const std::size_t group : of_both(spring.body_A, spring.body_B))
      groups[group].arms.push_back({spring.body_A, spring.body_B});
  std::vector<DriveTiming> drives(groups.size());
  for (const auto& [actuator, signal] : assembly.drive)
    for (const std::size_t group : of_both(actuator.body_A, actuator.body_B < 0 ? actuator.body_A : actuator.body_B))
      drives[group].add(signal);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const bool is_named = i >= the_case.swimmers.size();
    drives[i].set_cycles(is_named ? the_case.groups[i - the_case.swimmers.size()].period_steps : 0, groups[i]);
  }
  return groups;
}

bool have_cycles(const std::vector<Group>& groups) {
  return std::ranges::any_of(groups, [](const Group& group) { return group.period_steps > 0; });
}

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
  for (Eigen::Index arm = 0; arm < arms; ++arm) sums.first_arm_m[arm] = arm_m(group.arms[arm], record);
  for (Eigen::VectorXd* sum : {&sums.arm_m, &sums.arm_cosine_m, &sums.arm_sine_m}) sum->setZero(arms);
  for (Eigen::VectorXd* speed : {&sums.max_speed_m_per_s, &sums.max_speed_along_m_per_s})
    speed->setZero(group.bodies.size());
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
  for (Eigen::Index arm = 0; arm < std::ssize(group.arms); ++arm) {
    const double change = arm_m(group.arms[arm], record) - sums.first_arm_m[arm];
    sums.arm_m[arm] += change;
    sums.arm_cosine_m[arm] += change * cosine_;
    sums.arm_sine_m[arm] += change * sine_;
  }
  const Eigen::Vector3d axis = sums.turned * group.axis;
  for (Eigen::Index i = 0; i < std::ssize(group.bodies); ++i) {
    const int body = group.bodies[i];
    const Eigen::Vector3d v = record.kinematics.velocity_m_per_s.col(body);
    const Eigen::Vector3d w = record.kinematics.angular_velocity_rad_per_s.col(body);
    sums.power_W += record.drive.force_N.col(body).dot(v) + record.drive.torque_N_m.col(body).dot(w);
    sums.dissipation_W -= record.applied.force_N.col(body).dot(v) + record.applied.torque_N_m.col(body).dot(w);
    double& fastest = sums.max_speed_m_per_s[i];
    double& fastest_along = sums.max_speed_along_m_per_s[i];
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
    const Eigen::Index kept = std::min(sums.latest_along_m.size(), most_latest_cycles - 1);
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
