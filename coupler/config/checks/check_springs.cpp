#include <algorithm>
#include <cmath>

#include "config/checks/checks.hpp"
#include "config/checks/spring_stability.hpp"
#include "config/sections/case.hpp"

namespace copepod::coupler {

void check_springs(const Case&, const Assembly& assembly, Problems& problems) {
  for (std::size_t i = 0; i < assembly.springs.size(); ++i) {
    const SpringSpecification& spring = assembly.springs[i];
    if (spring.body_A < 0 || spring.body_B < 0) continue;  // reported by check_names
    const std::string& path = assembly.spring_paths[i];
    if (spring.body_A == spring.body_B) {
      problems.error(path + ".bodies", "a spring joins '" +
                                           assembly.bodies[static_cast<std::size_t>(spring.body_A)].name +
                                           "' to itself (it needs two ends). Name two different bodies.");
      continue;
    }
    const Eigen::Vector3d between = assembly.bodies[static_cast<std::size_t>(spring.body_B)].position_m -
                                    assembly.bodies[static_cast<std::size_t>(spring.body_A)].position_m;
    const bool anchored = !spring.anchor_A_m.isZero(0.0) || !spring.anchor_B_m.isZero(0.0);
    const double stretch = std::abs(between.norm() - spring.rest_length_m);
    if (!anchored && stretch > 0.5 * std::max(spring.rest_length_m, between.norm())) {
      problems.warning(path, "a spring of rest length " + shortest_text(spring.rest_length_m) + " m starts at " +
                                 shortest_text(between.norm()) +
                                 " m (it will jerk its bodies). Check rest_length_m and positions.");
    }
  }
}

void check_stiffness(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const bool ours = the_case.body.solver == BodySolverChoice::own && the_case.services.body_command.empty();
  if (!ours || assembly.springs.empty()) return;
  const Integrator integrator = the_case.body.integrator;
  const FastestSprings fastest = fastest_springs(assembly.bodies, assembly.springs, {}, integrator);
  constexpr double close = 0.8;
  if (the_case.step_s <= close * fastest.together.largest_step_s) return;
  const bool diverges = the_case.step_s > fastest.alone.largest_step_s;
  const StepLimit& limiting = diverges ? fastest.alone : fastest.together;
  const SpringSpecification& spring = assembly.springs[limiting.spring];
  const std::string found = "the spring between '" + assembly.bodies[static_cast<std::size_t>(spring.body_A)].name +
                            "' and '" + assembly.bodies[static_cast<std::size_t>(spring.body_B)].name +
                            "' is too stiff or too damped for a step of " + shortest_text(the_case.step_s) + " s (";
  const std::string limit = name_of(integrator_names, integrator) +
                            std::string(diverges ? " diverges" : " may diverge") + " above " +
                            shortest_text(limiting.largest_step_s) + " s";
  const std::string remedy = "Use a smaller step, a softer spring, less damping or heavier bodies.";
  const std::string& path = assembly.spring_paths[limiting.spring];
  if (diverges) {
    problems.error(path, found + limit + "). " + remedy);
  } else {
    problems.warning(path, found + limit + ": close to it oscillations are wrong). " + remedy);
  }
}

}  // namespace copepod::coupler
