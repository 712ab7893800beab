#include "analysis/groups.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/as_in_paper.hpp"
#include "analysis/swimmer_figures.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

/// Half the extent of a body along a direction [m].
double half_extent_m(const BodySpecification& body, const Eigen::Vector3d& direction) {
  return body.shape.radius_m + core_half_length_m(body.shape) * std::abs(z_axis(body.orientation_wxyz).dot(direction));
}

/// Greatest distance between the surfaces of two of the bodies, or a body's own extent along `axis` [m].
double length_m(const std::vector<BodySpecification>& bodies, const Eigen::Vector3d& axis) {
  double length = 0.0;
  for (const BodySpecification& one : bodies) {
    length = std::max(length, 2.0 * half_extent_m(one, axis));
    for (const BodySpecification& other : bodies) {
      const Eigen::Vector3d between_m = other.position_m - one.position_m;
      const double distance_m = between_m.norm();
      if (distance_m == 0.0) continue;
      const Eigen::Vector3d along = between_m / distance_m;
      length = std::max(length, half_extent_m(one, along) + distance_m + half_extent_m(other, along));
    }
  }
  return length;
}

/// Period and full cycles of the signals that drive a swimmer.
void set_period(const std::vector<const Signal*>& signals, Group& group) {
  std::int64_t start = Signal::never, stop = Signal::never;
  bool differ = false;
  for (const Signal* signal : signals) {
    if (signal->period_steps == 0) continue;
    differ = differ || (group.period_steps != 0 && signal->period_steps != group.period_steps);
    group.period_steps = std::max(group.period_steps, signal->period_steps);
    start = std::min(start, signal->start_step);
    stop = std::min(stop, signal->stop_step);
  }
  if (group.period_steps == 0) {
    group.note = "nothing drives it periodically, so there are no cycles to measure";
    return;
  }
  if (differ) group.note = "its drives have different periods; cycles are those of the longest";
  group.first_cycle = (start + group.period_steps - 1) / group.period_steps;
  group.stop_cycle = stop / group.period_steps;
}

}  // namespace

std::vector<Group> groups_of(const Case& the_case, const Assembly& assembly) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Swimmer& swimmer = the_case.swimmers[i];
    const int first_body = assembly.first_bodies[i];
    Group& group = groups.emplace_back();
    group.name = swimmer.name;
    group.axis = z_axis(swimmer.orientation_wxyz);
    group.placed_m.resize(3, static_cast<Eigen::Index>(swimmer.beads.size()));
    const std::vector<BodySpecification> bodies(assembly.bodies.begin() + first_body,
                                                assembly.bodies.begin() + first_body + group.placed_m.cols());
    for (int bead = 0; bead < static_cast<int>(bodies.size()); ++bead) {
      const BodySpecification& body = bodies[static_cast<std::size_t>(bead)];
      group.bodies.push_back(first_body + bead);
      group.body_names.push_back(body.name);
      group.placed_m.col(bead) = body.position_m;
      group.radius_m += equivalent_radius_m(body.shape);
    }
    group.length_m = length_m(bodies, group.axis);
    std::vector<const Signal*> signals;
    for (const Arm& arm : swimmer.arms) {
      group.arms.push_back({first_body + arm.bead_A, first_body + arm.bead_B});
      if (arm.drive) signals.push_back(&arm.drive->signal);
    }
    set_period(signals, group);
    if (swimmer.three_beads && !swimmer.published.empty()) {
      group.power_as_in_paper_W = [stroke = swimmer.three_beads->stroke, first_body](const StepRecord& record,
                                                                                     const Eigen::Vector3d& axis) {
        return power_with_rounded_omega_W(stroke, first_body, axis, record);
      };
    }
  }
  return groups;
}

}  // namespace copepod::coupler
