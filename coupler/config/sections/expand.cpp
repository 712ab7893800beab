#include "config/sections/expand.hpp"

#include <unordered_map>

#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

void add_swimmer_bodies(const Swimmer& swimmer, const std::string& path, Assembly& assembly) {
  const Eigen::Matrix3d R_WS = rotation_matrix(swimmer.orientation_wxyz);
  assembly.first_bodies.push_back(static_cast<int>(assembly.bodies.size()));
  for (const Bead& bead : swimmer.beads) {
    assembly.body_paths.push_back(path + ".beads." + std::to_string(&bead - swimmer.beads.data()));
    BodySpecification& body = assembly.bodies.emplace_back();
    body.name = swimmer.name + "." + bead.name;
    body.shape = bead.shape;
    body.mass_kg = bead.mass_kg;
    body.position_m = swimmer.center_m + R_WS * bead.position_m;
    if (bead.shape.kind != ShapeKind::sphere)
      body.orientation_wxyz = product(swimmer.orientation_wxyz, bead.orientation_wxyz);
  }
}

void add_swimmer_springs(const Swimmer& swimmer, int first_body, const std::string& path, Assembly& assembly) {
  for (const Arm& arm : swimmer.arms) {
    SpringSpecification& spring = assembly.springs.emplace_back();
    spring.body_A = first_body + arm.bead_A;
    spring.body_B = first_body + arm.bead_B;
    spring.stiffness_N_per_m = arm.stiffness_N_per_m;
    spring.damping_N_s_per_m = arm.damping_N_s_per_m;
    spring.rest_length_m = arm.rest_length_m;
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
    DrivenActuator driven{{}, named};
    driven.actuator.kind = ActuatorKind::world_force;
    driven.actuator.body_A = number_of(numbers, named.name);
    driven.term.amplitude = named.amplitude_N.norm();
    if (driven.term.amplitude > 0.0) driven.actuator.direction = named.amplitude_N / driven.term.amplitude;
    assembly.drive.push_back(driven);
    assembly.drive_paths.push_back("forces." + std::to_string(i));
  }
}

}  // namespace

Assembly assemble(const Case& the_case) {
  Assembly assembly;
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Swimmer& swimmer = the_case.swimmers[i];
    const std::string path = "swimmers." + std::to_string(i);
    add_swimmer_bodies(swimmer, path, assembly);
    const int first_body = assembly.first_bodies.back();
    add_swimmer_springs(swimmer, first_body, path, assembly);
    const Stroke& stroke = swimmer.three_beads->stroke;
    for (const DrivenActuator& driven :
         stroke_terms(stroke.amplitude_N, stroke.period_steps, stroke.phase_lag_steps, stroke.cycles, first_body)) {
      assembly.drive.push_back(driven);
      assembly.drive_paths.push_back(path + ".stroke");
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
