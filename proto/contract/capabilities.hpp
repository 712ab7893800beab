#pragma once

#include <set>
#include <string>

namespace copepod {

/// What a component can do, announced in its Hello; the coupler refuses a case that needs more.
/// Feature names are listed in contract/features.hpp; most are keys of the case file with their value:
/// "collision:trt", "boundary:pressure", "motion:axis". A component that leaves out something a case may ask
/// for announces "neglects:NAME" ("neglects:boundary", "neglects:symmetry_planes"); a run reports it.
struct Capabilities {
  std::string name;                ///< of the component, for people: "Copepod lattice Boltzmann"
  std::string version;             ///< its own, for people
  std::set<std::string> features;  ///< see above
};

}  // namespace copepod
