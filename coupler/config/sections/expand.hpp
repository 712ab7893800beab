#pragma once

#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "contract/body_setup.hpp"
#include "driving/driving_protocol.hpp"

namespace copepod::coupler {

/// All bodies, springs and actuators of a case: swimmers expanded, names turned into positions in
/// `bodies`. Bodies of swimmers come first, bead by bead.
struct Assembly {
  std::vector<BodySpecification> bodies;
  std::vector<std::string> body_paths;  ///< key path in the case that each body came from
  std::vector<int> first_bodies;        ///< of each swimmer: the body of its first bead; the others follow
  std::vector<SpringSpecification> springs;
  std::vector<std::string> spring_paths;
  std::vector<DrivenActuator> drive;
  std::vector<std::string> drive_paths;
};

/// Names that do not exist give a term with body −1; `check_names` reports them.
Assembly assemble(const Case& the_case);

}  // namespace copepod::coupler
