#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "contract/component.hpp"

namespace copepod::doubles {

/// What a fake component does wrong, for tests of how others take it.
struct Misbehaviour {
  std::int64_t hang_at_step = -1;              ///< never returns from the exchange of that step
  std::int64_t throw_at_step = -1;             ///< throws SolverError from the exchange of that step, as rank 3
  std::int64_t throw_in_advance_of_step = -1;  ///< fluid: throws from the bulk update, after the reply
  int slow_ms = 0;                             ///< every step takes so long
  bool reports_progress = false;               ///< and shows that it moves on meanwhile
};

/// A component whose solvers misbehave in that way.
FluidComponent misbehaving(const FluidComponent& component, const Misbehaviour& misbehaviour);
BodyComponent misbehaving(const BodyComponent& component, const Misbehaviour& misbehaviour);

}  // namespace copepod::doubles
