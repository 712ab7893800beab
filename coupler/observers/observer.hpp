#pragma once

#include <cstdint>

#include "contract/exchange.hpp"

namespace copepod::coupler {

/// What one step looked like, seen before the bodies move; SI units, world frame, all of step `step`.
struct StepRecord {
  std::int64_t step = 0;
  const Kinematics& kinematics;  ///< at the start of the step
  const Loads& raw;              ///< as the fluid returned them
  const Loads& applied;          ///< after averaging: what acts on the bodies
  const Loads& drive;            ///< of all actuators, at the start of the step
  const Loads& obstacles;        ///< on those with loads
};

/// Looks at a run and never changes it; all output of a run is made by observers.
class Observer {
 public:
  virtual ~Observer() = default;

  /// Called once per step, in order.
  virtual void observe(const StepRecord& record) = 0;

  /// Called once after the last step, with the state at its end and the loads and forces that led there.
  virtual void finish(const StepRecord& last) = 0;
};

}  // namespace copepod::coupler
