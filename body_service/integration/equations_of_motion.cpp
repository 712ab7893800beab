#include <algorithm>
#include <utility>

#include "integration/integration.hpp"
#include "model/vector_loops.hpp"

namespace copepod::body {

namespace {

std::vector<std::unique_ptr<const ForceElement>> make_force_elements(const BodySetup& setup) {
  std::vector<std::unique_ptr<const ForceElement>> elements;
  // Zero added to a sum that began at zero changes no bit.
  if (!setup.gravity_m_per_s2.isZero(0.0)) elements.push_back(std::make_unique<Weight>(setup));
  elements.push_back(std::make_unique<Springs>(setup));
  if (!setup.bends.empty()) elements.push_back(std::make_unique<Bends>(setup));
  return elements;
}

}  // namespace

EquationsOfMotion::Work::Work(Eigen::Index bodies)
    : hydrodynamic_force_N(3, bodies), hydrodynamic_torque_N_m(3, bodies), angular_velocity_rad_per_s(3, bodies) {}

// The order of the members matters: model and force elements check the setup before it is cut into blocks.
EquationsOfMotion::EquationsOfMotion(const BodySetup& setup, Eigen::Index preferred_block_bodies)
    : model_(setup),
      drive_(setup),
      elements_(make_force_elements(setup)),
      joints_(setup, model_),
      blocks_(independent_blocks(setup, preferred_block_bodies)) {}

Eigen::Index EquationsOfMotion::longest_block() const {
  Eigen::Index longest = 0;
  for (const auto& block : blocks_) longest = std::max(longest, block.bodies);
  return longest;
}

void EquationsOfMotion::begin(const BodyBlock& block, const AppliedLoads& applied, Work& work) const {
  split(applied.hydrodynamic.force_N, block, work.hydrodynamic_force_N);
  split(applied.hydrodynamic.torque_N_m, block, work.hydrodynamic_torque_N_m);
}

void EquationsOfMotion::evaluate(const BodyBlock& block, const AppliedLoads& applied, Eigen::Index node,
                                 const BlockState& state, BlockState& rate, Work& work) const {
  const Eigen::Index bodies = block.bodies;
  // Forces are summed where the accelerations will be, and torques where dL/dt is.
  auto& force_N = rate.velocity_m_per_s;
  auto& torque_N_m = rate.angular_momentum_N_m_s;

  model_.angular_velocities_rad_per_s(block, state, work.angular_velocity_rad_per_s);
  work.lines.measure(block, state.position_m);
  const Stage stage{block, state, work.angular_velocity_rad_per_s, work.lines, applied.actuation.col(node)};
  // The drive is summed by itself: what it adds to a bead between two arms has no rounding of the loads in it.
  force_N.leftCols(bodies).setZero();
  torque_N_m.leftCols(bodies).setZero();
  drive_.add_loads(stage, force_N, torque_N_m);
  force_N.leftCols(bodies) += work.hydrodynamic_force_N.leftCols(bodies);
  torque_N_m.leftCols(bodies) += work.hydrodynamic_torque_N_m.leftCols(bodies);
  for (const auto& element : elements_) element->add_loads(stage, force_N, torque_N_m);
  if (!joints_.empty())
    joints_.add_loads(block, state, 0.5 * static_cast<double>(node), force_N, torque_N_m, work.joints);

  if (!block.of_free_spheres) constrain(block, force_N, torque_N_m);
  rate.position_m.leftCols(bodies) = state.velocity_m_per_s.leftCols(bodies);
  for (double* const component : components(force_N))
    multiply(bodies, &model_.inverse_masses_per_kg()[block.first], component, component);
  const auto [w, x, y, z] = components(rate.orientation_wxyz);
  orientation_rates(bodies, components(std::as_const(work.angular_velocity_rad_per_s)),
                    components(state.orientation_wxyz), w, x, y, z);
}

void EquationsOfMotion::constrain(const BodyBlock& block, BlockVectors& force_N, BlockVectors& torque_N_m) const {
  for (Eigen::Index i = 0; i < block.bodies; ++i) {
    Eigen::Vector3d force = force_N.col(i);
    Eigen::Vector3d torque = torque_N_m.col(i);
    model_.constrain_loads(block.first + i, force, torque);
    force_N.col(i) = force;
    torque_N_m.col(i) = torque;
  }
}

}  // namespace copepod::body
