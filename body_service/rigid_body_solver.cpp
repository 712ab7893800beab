#include "rigid_body_solver.hpp"

#include "contract/errors.hpp"
#include "contract/features.hpp"
#include "geometry/contact_time.hpp"
#include "request_checks.hpp"
#include "storage/state_file.hpp"
#include "system/process.hpp"

namespace copepod::body {

namespace {

/// Bodies that are integrated together: their state and work arrays fit in a core's second-level cache.
constexpr Eigen::Index preferred_block_bodies = 256;

bool resolves_contacts(const BodySetup& setup) { return setup.contact.stiffness_N_per_m > 0.0; }

int checked_threads(const BodySetup& setup) {
  if (setup.threads >= 1 && setup.threads <= most_threads) return setup.threads;
  throw CaseError("services.body.threads " + std::to_string(setup.threads) + " (must be between 1 and " +
                  std::to_string(most_threads) + "). Use at most the number of cores.");
}

/// Weights of the values at the nodes for the polynomial through them, at the fraction `at` of the step.
Eigen::VectorXd interpolation_weights(const std::vector<double>& nodes, double at) {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < nodes.size(); ++j)
      if (j != i) weights[i] *= (at - nodes[j]) / (nodes[i] - nodes[j]);
  return weights;
}

/// @throws SolverError naming the first body of a block whose state is not finite
void check_finite(const BodyBlock& block, const BodyModel& model, const BlockState& state, std::int64_t step) {
  const auto finite = [&state](Eigen::Index first, Eigen::Index bodies) {
    bool all = true;
    const auto look_at = [&](const auto& rows) {
      all = all && all_finite(rows.rows(), rows.outerStride(), bodies, &rows(0, first));
    };
    for_each_part(look_at, state);
    return all;
  };
  if (finite(0, block.bodies)) return;
  for (Eigen::Index body = 0; body < block.bodies; ++body) {
    if (finite(body, 1)) continue;
    throw SolverError("the motion of body '" + model.name(block.first + body) +
                          "' is not finite (its loads are not, or the step is too long for its springs). Look at the "
                          "loads of the last steps, or use a shorter step.",
                      0, step);
  }
}

void split(const MotionState& state, const BodyBlock& block, BlockState& of_block) {
  for_each_part([&](const auto& all, auto& part) { split(all, block, part); }, state, of_block);
}

void join(const BlockState& of_block, const BodyBlock& block, MotionState& state) {
  for_each_part([&](const auto& part, auto& all) { join(part, block, all); }, of_block, state);
}

}  // namespace

Capabilities rigid_body_capabilities() {
  return {"Copepod rigid bodies", COPEPOD_VERSION,
          features_in("shape:sphere shape:capsule shape:ellipsoid shape:cylinder shape:box shape:mesh shape:compound "
                      "inertia motion:free motion:fixed motion:prescribed motion:axis integrator:semi_implicit_euler "
                      "integrator:runge_kutta_4 springs anchors bends joint:ball joint:hinge joint:slider joint:fixed "
                      "joint:distance joint:springs joint:limits actuator:pair_force actuator:body_force "
                      "actuator:body_torque actuator:world_force actuator:world_torque actuator:joint_motion gravity "
                      "contact contact:friction walls removal periodic checkpoint snapshots")};
}

RigidBodySolver::RigidBodySolver(const BodySetup& setup, SolverContext* context)
    : context_(context),
      layout_digest_(layout_digest(setup)),
      equations_(setup, preferred_block_bodies),
      integrator_(setup.integrator),
      work_(checked_threads(setup), IntegratorWork(equations_.longest_block())),
      team_(setup.threads),
      step_s_(setup.step_s),
      actuators_(setup.actuators.size()),
      nodes_(body::driving_nodes(setup.integrator)),
      exits_(setup, equations_.model()),
      near_pairs_(equations_.model().shapes(), resolves_contacts(setup) ? Contacts::reach_m(setup) : 0.0,
                  setup.periodic_length_m, jointed_pairs(setup.joints)),
      overlap_check_(equations_.model(), near_pairs_, setup.contact),
      state_(equations_.model().initial_state()) {
  require_positive_step(setup.step_s);
  correct_joints(0.0);
  overlap_check_.check(state_, step_, team_);
  if (resolves_contacts(setup)) contacts_.emplace(setup, equations_.model(), equations_.joints(), near_pairs_);
  substeps_ = static_cast<std::int64_t>(contact_substeps(setup));
}

void RigidBodySolver::kinematics(Kinematics& kinematics) {
  kinematics.step = step_;
  kinematics.resize(state_.bodies());
  for_each_block([&](const BodyBlock& block, IntegratorWork& work) {
    split(state_, block, work.state);
    write(block, work, kinematics);
  });
}

void RigidBodySolver::write(const BodyBlock& block, IntegratorWork& work, Kinematics& kinematics) const {
  BlockVectors& w_WB_rad_per_s = work.equations.angular_velocity_rad_per_s;
  equations_.model().angular_velocities_rad_per_s(block, work.state, w_WB_rad_per_s);
  join(work.state.position_m, block, kinematics.position_m);
  join(work.state.orientation_wxyz, block, kinematics.orientation_wxyz);
  join(work.state.velocity_m_per_s, block, kinematics.velocity_m_per_s);
  join(w_WB_rad_per_s, block, kinematics.angular_velocity_rad_per_s);
}

void RigidBodySolver::step(const AppliedLoads& applied, Kinematics& next) {
  require_matching_loads(applied, step_, state_.bodies(), actuators_, std::ssize(nodes_));
  const double start_s = now_s();
  const double before_s = contact_s_;
  next.resize(state_.bodies());
  const Eigen::Matrix3Xd before_m = exits_.empty() ? Eigen::Matrix3Xd() : state_.position_m;
  if (contacts_)
    integrate_with_contacts(applied);
  else
    integrate(applied, step_s_, &next);
  ++step_;
  const double integrated_s = now_s();
  integration_s_ += integrated_s - start_s - (contact_s_ - before_s);

  if (!exits_.empty()) exits_.remove_bodies(before_m, state_);
  if (!contacts_) overlap_check_.check(state_, step_, team_);
  contact_s_ += now_s() - integrated_s;
  next.step = step_;
  if (contacts_ || !exits_.empty()) kinematics(next);
}

void RigidBodySolver::integrate(const AppliedLoads& applied, double step_s, Kinematics* next) {
  equations_.joints().drive(applied.actuation, step_s);
  for_each_block([&](const BodyBlock& block, IntegratorWork& work) {
    split(state_, block, work.state);
    advance(integrator_, equations_, block, applied, step_s, work);
    join(work.state, block, state_);
    if (!equations_.joints().empty()) {
      equations_.joints().correct(block, 1.0, state_, step_, work.equations.joints);
      split(state_, block, work.state);
    }
    check_finite(block, equations_.model(), work.state, step_);
    if (next != nullptr) write(block, work, *next);  // while the block is in the cache
  });
}

void RigidBodySolver::correct_joints(double at) {
  for_each_block([&](const BodyBlock& block, IntegratorWork& work) {
    equations_.joints().correct(block, at, state_, step_, work.equations.joints);
  });
}

void RigidBodySolver::integrate_with_contacts(const AppliedLoads& applied) {
  const auto substeps = static_cast<double>(substeps_);
  const double substep_s = step_s_ / substeps;
  applied_in_part_.hydrodynamic = applied.hydrodynamic;
  for (std::int64_t substep = 0; substep < substeps_; ++substep) {
    const double from = static_cast<double>(substep) / substeps;
    const double to = static_cast<double>(substep + 1) / substeps;
    interpolate_drive(applied, from, to);
    const double part_s = (to - from) * step_s_;
    if (substep == 0) {
      equations_.joints().drive(applied_in_part_.actuation, part_s);
      push_contacts({0.5 * substep_s, 0.25 * substep_s, 0.0, 0.0});
    }
    integrate(applied_in_part_, part_s, nullptr);
    if (substep + 1 < substeps_) push_contacts({substep_s, 0.0, substep_s, 1.0});
  }
  push_contacts({0.5 * substep_s, -0.25 * substep_s, substep_s, 1.0});
}

void RigidBodySolver::push_contacts(const Contacts::Interval& interval) {
  const double start_s = now_s();
  contacts_->push(state_, interval);
  correct_joints(interval.at);
  contact_s_ += now_s() - start_s;
}

void RigidBodySolver::interpolate_drive(const AppliedLoads& applied, double from, double to) {
  applied_in_part_.actuation.resize(actuators_, std::ssize(nodes_));
  for (Eigen::Index node = 0; node < std::ssize(nodes_); ++node) {
    const double at = from + nodes_[node] * (to - from);
    applied_in_part_.actuation.col(node) = applied.actuation * interpolation_weights(nodes_, at);
  }
}

void RigidBodySolver::save(const std::string& path) {
  write_state(path, layout_digest_, step_, state_, progress_reporter(context_), memory());
}

void RigidBodySolver::restore(const std::string& path) {
  std::vector<std::uint64_t> memory;
  step_ = read_state(path, layout_digest_, state_, progress_reporter(context_), contacts_ ? &memory : nullptr);
  if (contacts_)
    contacts_->restore(memory);
  else
    overlap_check_.check(state_, step_, team_);
}

SolverSummary RigidBodySolver::summarise() {
  SolverSummary summary;
  summary.digest = state_digest(step_, state_, memory());
  summary.seconds = {{"integrate", integration_s_}, {"contact", contact_s_}};
  return summary;
}

}  // namespace copepod::body
