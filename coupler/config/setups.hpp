#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/sections.hpp"
#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "contract/fluid_setup.hpp"
#include "driving/driving_protocol.hpp"

namespace copepod::coupler {

// What the components receive of a case, and what it needs of them.

/// @param field_directory  absolute path of the run directory
FluidSetup make_fluid_setup(const Case& the_case, const Assembly& assembly, const std::string& field_directory);
BodySetup make_body_setup(const Case& the_case, const Assembly& assembly);
ControllerSetup make_controller_setup(const Case& the_case, const Assembly& assembly, std::size_t number);

/// What 1 of a steered value is in the drive: the stiffness of its spring for a rest length, which acts as a force.
double unit_of_actuator(const Assembly& assembly, std::size_t number);
/// A controller with the bodies and actuators of its setup.
AttachedController attached(std::unique_ptr<Controller> controller, const ControllerSetup& setup,
                            const Assembly& assembly);

/// Features that a case requires of its components: those of the setup (contract/features.hpp) and those of
/// the run.
std::set<std::string> required_of_fluid(const Case& the_case, const Assembly& assembly);
std::set<std::string> required_of_body(const Case& the_case, const BodySetup& setup);

/// What to report to the user about a component: required features that it neglects, and announced names that
/// are not features.
/// @throws Refused naming the features that the component lacks
std::vector<std::string> require_features(const Capabilities& capabilities, const std::set<std::string>& required);

/// Loads that contacts of a case are likely to meet, as far as they follow from it.
struct ExpectedContacts {
  double smallest_radius_m = 0.0;
  double force_N = 0.0;              ///< weight of a column of bodies, or the drive
  double impact_N_m = 0.0;           ///< 2 m u², twice the energy of two bodies that meet with their expected speeds u
  double inverse_mass_per_kg = 0.0;  ///< see geometry/contact_time.hpp; 0: no body moves

  /// Overlap under the force and, by itself, in the impact: the larger of F/k and √(2 m u²/k) [m].
  [[nodiscard]] double overlap_m(double stiffness_N_per_m) const;
};

/// Speeds are those at the start, or those of settling: free fall over the domain, or Stokes drag, whichever is slower.
ExpectedContacts expected_contacts(const Case& the_case, const Assembly& assembly);

}  // namespace copepod::coupler
