#include "analysis/groups.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

#include "analysis/as_in_paper.hpp"
#include "analysis/swimmer_figures.hpp"
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
  group.placed_m.resize(3, static_cast<Eigen::Index>(numbers.size()));
  std::vector<BodySpecification> bodies;
  for (const int number : numbers) {
    const BodySpecification& body = bodies.emplace_back(assembly.bodies[static_cast<std::size_t>(number)]);
    group.placed_m.col(static_cast<Eigen::Index>(group.body_names.size())) = body.position_m;
    group.body_names.push_back(body.name);
    group.radii_m.push_back(equivalent_radius_m(body.shape));
  }
  group.length_m = length_m(bodies, group.placed_m, axis);
  return group;
}

/// Which groups hold which bodies.
class Membership {
 public:
  explicit Membership(const std::vector<Group>& groups) {
    for (std::size_t group = 0; group < groups.size(); ++group)
      for (const int body : groups[group].bodies) of_body_[body].push_back(group);
  }

  [[nodiscard]] std::vector<std::size_t> of_both(int body_A, int body_B) const {
    std::vector<std::size_t> both;
    const auto A = of_body_.find(body_A), B = of_body_.find(body_B);
    if (A == of_body_.end() || B == of_body_.end()) return both;
    std::ranges::set_intersection(A->second, B->second, std::back_inserter(both));
    return both;
  }

 private:
  std::unordered_map<int, std::vector<std::size_t>> of_body_;  ///< groups in ascending order
};

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

  const Membership membership(groups);
  for (const SpringSpecification& spring : assembly.springs)
    for (const std::size_t group : membership.of_both(spring.body_A, spring.body_B))
      groups[group].arms.push_back({spring.body_A, spring.body_B});
  std::vector<DriveTiming> drives(groups.size());
  for (const auto& [actuator, signal] : assembly.drive)
    for (const std::size_t group :
         membership.of_both(actuator.body_A, actuator.body_B < 0 ? actuator.body_A : actuator.body_B))
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

}  // namespace copepod::coupler
