#pragma once

#include <memory>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "integration/equations_of_motion.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// Advances the bodies of one block by a step, or by a part of one.
class TimeIntegrator {
 public:
  /// Of the block in work; each thread has its own.
  struct Work {
    /// @param bodies  of the longest block
    explicit Work(Eigen::Index bodies) : equations(bodies) {
      for (BlockState* part : {&state, &stage, &rate, &rate_sum}) part->resize(bodies);
    }

    BlockState state;  ///< of the bodies, column 0 is body block.first
    BlockState stage;
    BlockState rate;
    BlockState rate_sum;
    EquationsOfMotion::Work equations;
  };

  TimeIntegrator() = default;
  TimeIntegrator(const TimeIntegrator&) = delete;
  TimeIntegrator& operator=(const TimeIntegrator&) = delete;
  virtual ~TimeIntegrator() = default;

  /// See BodySolver::driving_nodes.
  [[nodiscard]] virtual std::vector<double> driving_nodes() const = 0;

  /// @param applied  with the drive at the driving nodes of these `step_s`
  /// @param work     its state is advanced
  /// @throws SolverError if a force is not defined in a state on the way
  virtual void advance(const BodyBlock& block, const AppliedLoads& applied, double step_s, Work& work) const = 0;
};

/// @param equations  must outlive the integrator
std::unique_ptr<TimeIntegrator> make_time_integrator(Integrator kind, const EquationsOfMotion& equations);

}  // namespace copepod::body
