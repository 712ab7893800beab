#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "config/sections/case.hpp"
#include "contract/body_solver.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_solver.hpp"
#include "driving/driving_protocol.hpp"
#include "observers/observer.hpp"
#include "scheme/lubrication.hpp"
#include "scheme/plausibility.hpp"
#include "scheme/stopwatch.hpp"
#include "scheme/virtual_mass.hpp"

namespace copepod::coupler {

/// Loads that the bodies receive, computed from those that the fluid returns.
///   two_step:  F̄(n) = (F(n) + F(n−1)) / 2,   F̄(0) = F(0) / 2        [docs/theory.md, (C3); Ladd 1994]
///   none:      F̄(n) = F(n)
/// Averaging removes the step-to-step oscillation that the explicit coupling grows with light bodies. Bodies receive
/// all that the fluid gives, half a step late: no load counts twice, not even the large one of a sudden start.
class LoadAverage {
 public:
  /// @param not_averaged  bodies whose loads stay as they are
  explicit LoadAverage(LoadAveraging kind, std::vector<Eigen::Index> not_averaged = {})
      : kind_(kind), not_averaged_(std::move(not_averaged)) {}

  /// @param raw      loads of step n; steps must come in order
  /// @param applied  overwritten with the loads to apply in step n
  void apply(const Loads& raw, Loads& applied);

  [[nodiscard]] bool averages() const { return kind_ != LoadAveraging::none; }

  /// Raw loads of the step before, all that is needed to continue bit for bit; empty before the first step.
  [[nodiscard]] const Loads& previous() const { return previous_; }
  void restore(const Loads& previous) { previous_ = previous; }

 private:
  LoadAveraging kind_;
  std::vector<Eigen::Index> not_averaged_;
  Loads previous_;
};

/// Serial explicit coupling of one fluid and one body solver [paper, Algorithm 2]: fluid and bodies take
/// turns, each once per step, and nothing is iterated.
///
/// Legal call order: construct -> [restore] -> { run }* -> finish; references must outlive the scheme. An exception of
/// a solver leaves the scheme unusable.
class SerialExplicit {
 public:
  SerialExplicit(FluidSolver& fluid, BodySolver& body, const DrivingProtocol& driving, const Plausibility& plausibility,
                 LoadAveraging averaging, Observer& observer, Timeline& timeline, VirtualMass virtual_mass = {},
                 Lubrication lubrication = {});

  /// Advances to the start of step `stop`, or of the first step before which `pause` returns true.
  /// @param pause  asked before every step
  /// @throws what a solver, an observer or `pause` throws, and PeerFailed for a motion that is not plausible
  void run(std::int64_t stop, const std::function<bool(std::int64_t step)>& pause);

  /// Loads and kinematics of the step before, which averaging and virtual masses need: with the solvers' states all
  /// there is to save.
  [[nodiscard]] const Loads& previous_loads() const { return averaging_.previous(); }
  [[nodiscard]] const Kinematics& previous_kinematics() const { return virtual_mass_.previous(); }
  /// @param step  to which the solvers have been restored
  /// @throws StorageError if the parts do not belong together
  void restore(std::int64_t step, const Loads& previous_loads, const Kinematics& previous_kinematics);

  /// Hands the final state to the observer.
  void finish();

  /// Step that comes next, and the state of motion at its start.
  [[nodiscard]] std::int64_t step() const { return step_; }
  [[nodiscard]] const Kinematics& kinematics() const { return kinematics_; }

  /// Seconds spent waiting for each solver.
  [[nodiscard]] double fluid_wait_s() const { return fluid_watch_.seconds(); }
  [[nodiscard]] double body_wait_s() const { return body_watch_.seconds(); }

 private:
  void couple();

  FluidSolver& fluid_;
  BodySolver& body_;
  const DrivingProtocol& driving_;
  const Plausibility& plausibility_;
  LoadAverage averaging_;
  VirtualMass virtual_mass_;
  Lubrication lubrication_;
  Observer& observer_;
  Timeline& timeline_;
  std::vector<double> nodes_;

  std::int64_t step_ = 0;
  Kinematics kinematics_;
  Kinematics next_;
  Loads loads_;
  Loads averaged_;
  AppliedLoads applied_;
  Loads drive_;  ///< at the start of the step
  Stopwatch fluid_watch_{timeline_, "wait for fluid"};
  Stopwatch couple_watch_{timeline_, "couple"};
  Stopwatch body_watch_{timeline_, "wait for bodies"};
};

}  // namespace copepod::coupler
