#pragma once

#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "contract/body_setup.hpp"
#include "driving/driving_protocol.hpp"
#include "driving/prescribed_bodies.hpp"

namespace copepod::coupler {

/// All bodies, springs, bends, joints and actuators of a case: swimmers expanded, names turned into positions in
/// `bodies`. Bodies of swimmers come first, bead by bead.
struct Assembly {
  std::vector<BodySpecification> bodies;
  std::vector<std::string> body_paths;   ///< key path in the case that each body came from
  std::vector<int> first_bodies;         ///< of each swimmer: the body of its first bead; the others follow
  std::vector<std::vector<int>> groups;  ///< bodies of each group of the case
  std::vector<PrescribedBody> prescribed;
  std::vector<SpringSpecification> springs;
  std::vector<std::string> spring_paths;
  std::vector<BendSpecification> bends;
  std::vector<std::string> bend_paths;
  std::vector<JointSpecification> joints;  ///< in the order of the case
  std::vector<DrivenActuator> drive;
  /// Key path that each actuator came from: that of the actuator, of the arm, or of the stroke.
  std::vector<std::string> drive_paths;
  std::vector<std::string> signal_paths;  ///< of the actuators' signals
  std::vector<int> drive_springs;         ///< number of the spring whose rest length each varies; −1: none
};

/// Names that do not exist give body −1; `check_names` reports them.
Assembly assemble(const Case& the_case);

}  // namespace copepod::coupler
