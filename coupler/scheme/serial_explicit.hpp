#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "contract/body_solver.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_solver.hpp"
#include "driving/driving_protocol.hpp"
#include "observers/observer.hpp"
#include "scheme/load_averaging.hpp"
#include "scheme/plausibility.hpp"
#include "scheme/stopwatch.hpp"

namespace copepod::coupler {

/// Serial explicit coupling of one fluid and one body solver [paper, Algorithm 2]: fluid and bodies take
/// turns, each once per step, and nothing is iterated.
///
/// Legal call order: construct -> [restore_previous_loads] -> { run }* -> finish; all arguments must
/// outlive the scheme. An exception of a solver leaves the scheme unusable.
class SerialExplicit {
 public:
  SerialExplicit(FluidSolver& fluid, BodySolver& body, const DrivingProtocol& driving,
                 const Plausibility& plausibility, LoadAveraging averaging, Observer& observer);

  /// Advances to the start of step `stop`, or of the first step before which `pause` returns true.
  /// @param pause  asked before every step
  /// @throws what a solver, an observer or `pause` throws, and PeerFailed for a motion that is not plausible
  void run(std::int64_t stop, const std::function<bool(std::int64_t step)>& pause);

  /// Loads of the step before that the averaging needs: with the solvers' states all there is to save.
  [[nodiscard]] const Loads& previous_loads() const { return averaging_.previous(); }
  void restore_previous_loads(const Loads& loads) { averaging_.restore(loads); }

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
  Observer& observer_;
  std::vector<double> nodes_;

  std::int64_t step_ = 0;
  Kinematics kinematics_;
  Kinematics next_;
  Loads loads_;
  AppliedLoads applied_;
  Stopwatch fluid_watch_{"wait for fluid"};
  Stopwatch couple_watch_{"couple"};
  Stopwatch body_watch_{"wait for bodies"};
};

}  // namespace copepod::coupler
