#pragma once

#include "config/sections/case.hpp"
#include "contract/exchange.hpp"

namespace copepod::coupler {

/// Loads that the bodies receive, computed from those that the fluid returns.
///   two_step:  F̄(n) = (F(n) + F(n−1)) / 2,   F̄(0) = F(0)        [docs/theory.md, (C3); Ladd 1994]
///   none:      F̄(n) = F(n)
/// Averaging removes the step-to-step oscillation that the explicit coupling grows with light bodies.
class LoadAverage {
 public:
  explicit LoadAverage(LoadAveraging kind) : kind_(kind) {}

  /// @param raw      loads of step n; steps must come in order
  /// @param applied  overwritten with the loads to apply in step n
  void apply(const Loads& raw, Loads& applied);

  /// Raw loads of the step before, all that is needed to continue bit for bit; empty before the first step.
  [[nodiscard]] const Loads& previous() const { return previous_; }
  void restore(const Loads& previous) { previous_ = previous; }

 private:
  LoadAveraging kind_;
  Loads previous_;
};

}  // namespace copepod::coupler
