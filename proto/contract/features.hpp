#pragma once

#include <set>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod {

/// What a feature is required for.
enum class FeatureKind {
  physics,  ///< what is computed: also required of a component that replaces the solver named in the case
  method,   ///< how it is computed: not required of a component that announces "solver:external"
  run,      ///< what a run asks of the process
  remark,   ///< never required: announced for the user, the conformance tests and the deploy command
};

/// A feature that a component may announce in its Hello.
struct Feature {
  std::string name;     ///< "shape:sphere"
  FeatureKind kind;     ///< what it is required for
  std::string meaning;  ///< in a few words
};

/// Every feature name of this release, except "neglects:NAME", which exists for each physics and run feature
/// and for each of their groups ("neglects:boundary:velocity", "neglects:boundary").
const std::vector<Feature>& known_features();

/// The feature of that name; nullptr if there is none.
const Feature* find_feature(const std::string& name);

const char* name_of(FeatureKind kind);  ///< "physics", "method", "run" or "remark"

/// The features of a component, of which `names` has one after the other: "shape:sphere shape:box springs".
std::set<std::string> features_in(const std::string& names);

/// The features that a setup uses: for each field that is not essential to every solver, the feature that
/// guards it. Stokes flow and vacuum have no lattice and no domain, so only the lattice Boltzmann method
/// (which stands for external solvers too) asks for boundaries, symmetry planes, body force and fields.
std::set<std::string> required_features(const FluidSetup& setup);
std::set<std::string> required_features(const BodySetup& setup);  ///< the same of a setup of bodies

/// The same without those of kind method: for a case that names no solver of ours.
std::set<std::string> without_methods(std::set<std::string> required);

/// The announcements any one of which is enough where `feature` is required: itself, that it is neglected, and for
/// a method "solver:external".
std::set<std::string> accepted_for(const std::string& feature);

/// A requirement or announcement set against the other; each list is in alphabetical order.
struct FeatureComparison {
  struct Unknown {
    std::string name;                  ///< announced, but not a feature of this release
    std::string nearest;               ///< the known name closest to it; empty if none is close
  };                                   ///< a name that is not a feature
  std::vector<std::string> missing;    ///< required, neither announced nor neglected
  std::vector<std::string> neglected;  ///< required, and announced as "neglects:…"
  std::vector<Unknown> unknown;        ///< announced, but not a feature
};

/// What a component that announces these lacks of the required ones.
FeatureComparison compare_features(const std::set<std::string>& required, const std::set<std::string>& announced);

}  // namespace copepod
