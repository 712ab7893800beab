#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "contract/exchange.hpp"
#include "contract/solver.hpp"

namespace copepod {

/// Everything that a controller needs before its first observation; SI units.
struct ControllerSetup {
  std::string name;                    ///< in the case
  double step_s = 0.0;                 ///< of the coupling
  std::int64_t every_steps = 1;        ///< between observations: steps that it divides are observed
  std::vector<std::string> bodies;     ///< names, in the order of Observation
  std::vector<std::string> actuators;  ///< key paths in the case, in the order of the action
  std::string parameters = "{}";       ///< of the case, JSON
  std::string trace_directory;         ///< absolute; where phases are recorded; empty: nowhere
  std::vector<std::string> flow = {};  ///< names of the values in Loads::flow, if the case samples the flow
};

/// What a controller sees of its bodies, one column per body.
struct Observation {
  Kinematics kinematics;  ///< at the start of the step
  Loads loads;            ///< hydrodynamic, during the step before, and the newest sample of the flow; zeros at first
};

/// Sees bodies now and then, and decides what actuators do. Its state is part of the run's: what it returns may depend
/// on its setup, on what it has observed, and on nothing else, so that a resumed run continues bit for bit.
///
/// Legal call order:
///   construct(ControllerSetup)  ->  [restore]  ->  { act -> [save] }*  ->  summarise
class Controller : public Solver {
 public:
  /// Forces, torques, rest lengths and controls have their value at once; a joint moves there until the next action.
  /// @return a value for each actuator from the step of `observation` on, in the unit of its signal in the case
  [[nodiscard]] virtual std::vector<double> act(const Observation& observation) = 0;

  /// All that `act` depends on beside its argument and the setup, for checkpoints; nothing for one that keeps nothing.
  [[nodiscard]] virtual std::string state() const { return {}; }
  virtual void set_state(const std::string& /*state*/) {}  ///< of a checkpoint, as `state` returned it

  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override { return {}; }
};

}  // namespace copepod
