#include "config/sections/expand.hpp"

#include <cmath>
#include <unordered_map>

namespace copepod::coupler {
namespace {

/// Shortest rotation that takes the body's z axis to the unit vector `direction`.
///   q = (√((1 + c)/2), z × d / (2 q_w)),  c = z · d
Eigen::Vector4d rotation_from_z(const Eigen::Vector3d& direction) {
  const double c = direction.z();
  if (c >= 1.0) return {1, 0, 0, 0};
  if (c <= -1.0) return {0, 1, 0, 0};
  const double w = std::sqrt((1.0 + c) / 2.0);
  return {w, -direction.y() / (2.0 * w), direction.x() / (2.0 * w), 0.0};
}

/// Unit vector perpendicular to the axis: along x where that is possible, else as close to a world axis as
/// can be.
Eigen::Vector3d across(const Eigen::Vector3d& axis) {
  Eigen::Index least = 0;
  axis.cwiseAbs().minCoeff(&least);
  Eigen::Vector3d candidate = Eigen::Vector3d::Unit(least);
  if (axis[least] == 0.0) return candidate;
  return (candidate - axis[least] * axis).normalized();
}

Eigen::Vector4d bead_orientation(const Bead& bead, const Eigen::Vector3d& axis) {
  if (bead.shape.kind == ShapeKind::sphere) return {1, 0, 0, 0};
  return rotation_from_z(bead.orientation == BeadOrientation::parallel ? axis : across(axis));
}

void add_swimmer_bodies(const Swimmer& swimmer, const std::string& path, Assembly& assembly) {
  constexpr std::array bead_names{".B2", ".B1", ".B3"};
  const auto [trailing_arm, leading_arm] = rest_arms_m(swimmer);
  const std::array offsets{-trailing_arm, 0.0, leading_arm};
  for (std::size_t bead = 0; bead < 3; ++bead) {
    BodySpecification body;
    body.name = swimmer.name + bead_names[bead];
    body.shape = swimmer.beads[bead].shape;
    body.mass_kg = swimmer.bead_mass_kg;
    body.position_m = swimmer.center_m + offsets[bead] * swimmer.axis;
    body.orientation_wxyz = bead_orientation(swimmer.beads[bead], swimmer.axis);
    assembly.bodies.push_back(body);
    assembly.body_paths.push_back(path + ".beads." + std::to_string(bead));
  }
}

void add_swimmer_springs(const Swimmer& swimmer, int first_body, const std::string& path, Assembly& assembly) {
  const std::array<double, 2> arms = rest_arms_m(swimmer);
  for (int arm = 0; arm < 2; ++arm) {
    SpringSpecification spring;
    spring.body_A = first_body + arm;
    spring.body_B = first_body + arm + 1;
    spring.stiffness_N_per_m = swimmer.stiffness_N_per_m;
    spring.damping_N_s_per_m = swimmer.damping_N_s_per_m;
    spring.rest_length_m = arms[static_cast<std::size_t>(arm)];
    assembly.springs.push_back(spring);
    assembly.spring_paths.push_back(path + ".spring");
  }
}

using BodyNumbers = std::unordered_map<std::string, int>;

/// Of two bodies with one name, an error, the first counts.
BodyNumbers numbers_of(const std::vector<BodySpecification>& bodies) {
  BodyNumbers numbers;
  for (std::size_t i = 0; i < bodies.size(); ++i) numbers.emplace(bodies[i].name, static_cast<int>(i));
  return numbers;
}

int number_of(const BodyNumbers& numbers, const std::string& name) {
  const auto found = numbers.find(name);
  return found == numbers.end() ? -1 : found->second;
}

void add_case_springs(const Case& the_case, const BodyNumbers& numbers, Assembly& assembly) {
  for (std::size_t i = 0; i < the_case.springs.size(); ++i) {
    const NamedSpring& named = the_case.springs[i];
    SpringSpecification& spring = assembly.springs.emplace_back(named);
    spring.body_A = number_of(numbers, named.bodies[0]);
    spring.body_B = number_of(numbers, named.bodies[1]);
    assembly.spring_paths.push_back("springs." + std::to_string(i));
  }
}

void add_case_forces(const Case& the_case, const BodyNumbers& numbers, Assembly& assembly) {
  for (std::size_t i = 0; i < the_case.forces.size(); ++i) {
    const NamedForce& named = the_case.forces[i];
    assembly.driving.emplace_back(named).body = number_of(numbers, named.name);
    assembly.driving_paths.push_back("forces." + std::to_string(i));
  }
}

}  // namespace

double extent_along_m(const Bead& bead) {
  const bool lengthwise = bead.orientation == BeadOrientation::parallel;
  return 2.0 * bead.shape.radius_m + (lengthwise ? bead.shape.length_m : 0.0);
}

double extent_across_m(const Bead& bead) {
  const bool lengthwise = bead.orientation == BeadOrientation::parallel;
  return 2.0 * bead.shape.radius_m + (lengthwise ? 0.0 : bead.shape.length_m);
}

std::array<double, 2> rest_arms_m(const Swimmer& swimmer) {
  std::array<double, 2> arms{};
  for (std::size_t arm = 0; arm < 2; ++arm) {
    arms[arm] =
        swimmer.rest_gap_m[arm] + (extent_along_m(swimmer.beads[arm]) + extent_along_m(swimmer.beads[arm + 1])) / 2.0;
  }
  return arms;
}

Assembly assemble(const Case& the_case) {
  Assembly assembly;
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Swimmer& swimmer = the_case.swimmers[i];
    const std::string path = "swimmers." + std::to_string(i);
    const int first_body = first_body_of_swimmer(i);
    add_swimmer_bodies(swimmer, path, assembly);
    add_swimmer_springs(swimmer, first_body, path, assembly);
    for (DrivingTerm& term : stroke_terms(swimmer.stroke.amplitude_N * swimmer.axis, swimmer.stroke.period_steps,
                                          swimmer.stroke.phase_lag_steps, swimmer.stroke.cycles, first_body)) {
      assembly.driving.push_back(term);
      assembly.driving_paths.push_back(path + ".stroke");
    }
  }
  for (std::size_t i = 0; i < the_case.bodies.size(); ++i) {
    assembly.bodies.push_back(the_case.bodies[i]);
    assembly.body_paths.push_back("bodies." + std::to_string(i));
  }
  const BodyNumbers numbers = numbers_of(assembly.bodies);
  add_case_springs(the_case, numbers, assembly);
  add_case_forces(the_case, numbers, assembly);
  return assembly;
}

}  // namespace copepod::coupler
