#pragma once

#include <vector>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "integration/equations_of_motion.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// Of the block in work; each thread has its own.
struct IntegratorWork {
  /// @param bodies  of the longest block
  explicit IntegratorWork(Eigen::Index bodies) : equations(bodies) {
    for (BlockState* part : {&state, &stage, &rate, &rate_sum}) part->resize(bodies);
  }

  BlockState state;  ///< of the bodies, column 0 is body block.first
  BlockState stage;
  BlockState rate;
  BlockState rate_sum;
  EquationsOfMotion::Work equations;
};

/// See BodySolver::driving_nodes.
/// @throws CaseError for an unknown integrator
std::vector<double> driving_nodes(Integrator kind);

/// Advances the bodies of one block by a step, or by a part of one.
/// @param applied  with the drive at the driving nodes of these `step_s`
/// @param work     its state is advanced
/// @throws SolverError if a force is not defined in a state on the way
void advance(Integrator kind, const EquationsOfMotion& equations, const BodyBlock& block, const AppliedLoads& applied,
             double step_s, IntegratorWork& work);

}  // namespace copepod::body
