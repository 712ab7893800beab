#include "integration/equations_of_motion.hpp"

#include <algorithm>

#include "constraints/motion_constraint.hpp"
#include "forces/bends.hpp"
#include "forces/springs.hpp"
#include "forces/weight.hpp"
#include "geometry/rotation.hpp"

namespace copepod::body {

namespace {

std::vector<std::unique_ptr<const ForceElement>> make_force_elements(const BodySetup& setup) {
  std::vector<std::unique_ptr<const ForceElement>> elements;
  elements.push_back(std::make_unique<Weight>(setup));
  elements.push_back(std::make_unique<Springs>(setup));
  elements.push_back(std::make_unique<Bends>(setup));
  return elements;
}

}  // namespace

// The order of the members matters: model and force elements check the setup before it is cut into blocks.
EquationsOfMotion::EquationsOfMotion(const BodySetup& setup, Eigen::Index preferred_block_bodies)
    : model_(setup),
      drive_(setup),
      elements_(make_force_elements(setup)),
      joints_(setup, model_),
      blocks_(independent_blocks(setup, preferred_block_bodies)) {
  angular_velocity_rad_per_s_.resize(3, longest_block());
}

Eigen::Index EquationsOfMotion::longest_block() const {
  Eigen::Index longest = 0;
  for (const auto& block : blocks_) longest = std::max(longest, block.bodies);
  return longest;
}

void EquationsOfMotion::evaluate(const BodyBlock& block, const AppliedLoads& applied, Eigen::Index node,
                                 const MotionState& state, MotionState& rate) {
  const Eigen::Index first = block.first;
  const Eigen::Index bodies = block.bodies;
  // Forces are summed where the accelerations will be, and torques where dL/dt is.
  auto& force_N = rate.velocity_m_per_s;
  auto& torque_N_m = rate.angular_momentum_N_m_s;

  for (Eigen::Index i = 0; i < bodies; ++i) {
    angular_velocity_rad_per_s_.col(i) = model_.angular_velocity_rad_per_s(first + i, state.orientation_wxyz.col(i),
                                                                           state.angular_momentum_N_m_s.col(i));
  }
  const Stage stage{block, state, angular_velocity_rad_per_s_, applied.actuation.col(node)};
  // The drive is summed by itself: what it adds to a bead between two arms has no rounding of the loads in it.
  force_N.leftCols(bodies).setZero();
  torque_N_m.leftCols(bodies).setZero();
  drive_.add_loads(stage, force_N, torque_N_m);
  force_N.leftCols(bodies) += applied.hydrodynamic.force_N.middleCols(first, bodies);
  torque_N_m.leftCols(bodies) += applied.hydrodynamic.torque_N_m.middleCols(first, bodies);
  for (const auto& element : elements_) element->add_loads(stage, force_N, torque_N_m);
  if (!joints_.empty()) joints_.add_loads(block, state, 0.5 * static_cast<double>(node), force_N, torque_N_m);

  rate.position_m.leftCols(bodies) = state.velocity_m_per_s.leftCols(bodies);
  for (Eigen::Index i = 0; i < bodies; ++i) {
    const Eigen::Index body = first + i;
    constrain_loads(model_.motion(body), model_.axis(body), force_N.col(i), torque_N_m.col(i));
    force_N.col(i) *= model_.inverse_mass_per_kg(body);
    rate.orientation_wxyz.col(i) = orientation_rate(angular_velocity_rad_per_s_.col(i), state.orientation_wxyz.col(i));
  }
}

}  // namespace copepod::body
