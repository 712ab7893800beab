#pragma once

#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "contract/body_setup.hpp"
#include "driving/driving_protocol.hpp"

namespace copepod::coupler {

/// All bodies, springs and driving forces of a case: swimmers expanded, names turned into positions in
/// `bodies`. Bodies of swimmers come first, each as trailing, middle, leading ("name.B2", "name.B1",
/// "name.B3").
struct Assembly {
  std::vector<BodySpecification> bodies;
  std::vector<std::string> body_paths;  ///< key path in the case that each body came from
  std::vector<SpringSpecification> springs;
  std::vector<std::string> spring_paths;
  std::vector<DrivingTerm> driving;
  std::vector<std::string> driving_paths;
};

/// Number of the first body of swimmer `index` in Assembly::bodies; middle and leading follow.
inline int first_body_of_swimmer(std::size_t index) { return static_cast<int>(3 * index); }

/// Extent of a bead along the swimmer's axis [m]: 2r, and the cylinder's length for a parallel capsule.
double extent_along_m(const Bead& bead);
/// Extent across the axis [m].
double extent_across_m(const Bead& bead);

/// Rest lengths of both arms, centre to centre [m]: gap and the two half extents.
std::array<double, 2> rest_arms_m(const Swimmer& swimmer);

/// Names that do not exist give a term with body −1; `check_names` reports them.
Assembly assemble(const Case& the_case);

}  // namespace copepod::coupler
