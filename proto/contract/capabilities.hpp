#pragma once

#include <set>
#include <string>

namespace copepod {

/// What a component can do, announced in its Hello; the coupler refuses a case that needs more.
/// Feature names are those of the case file, with the section in front: "collision:trt", "boundary:pressure",
/// "precision:single", "symmetry_planes", "shape:capsule", "motion:axis", "integrator:runge_kutta_4",
/// "checkpoint", "fields", "solver:vacuum". Three more tell what a solver leaves out by nature, so that
/// nobody expects it: "neglects:loads" and "neglects:torques" (of a fluid, or on bodies), "imposes:flow" (a
/// fluid that is not at rest to begin with).
struct Capabilities {
  std::string name;  ///< of the component, for people: "Copepod lattice Boltzmann"
  std::string version;
  std::set<std::string> features;
};

}  // namespace copepod
