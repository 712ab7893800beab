#include "engine/engine_body_solver.hpp"

#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "geometry/contact_time.hpp"
#include "request_checks.hpp"
#include "storage/state_file.hpp"
#include "system/process.hpp"

namespace copepod::body {

namespace {

const BodySetup& checked(const BodySetup& setup) {
  require_positive_step(setup.step_s);
  return setup;
}

/// One block, as an engine moves all bodies together.
BodyBlock all_bodies(const BodySetup& setup) {
  const auto blocks = independent_blocks(setup, setup.bodies.size());
  return blocks.empty() ? BodyBlock{} : blocks.front();
}

bool is_finite(const Kinematics& state) {
  return state.position_m.allFinite() && state.orientation_wxyz.allFinite() && state.velocity_m_per_s.allFinite() &&
         state.angular_velocity_rad_per_s.allFinite();
}

}  // namespace

EngineBodySolver::EngineBodySolver(std::string_view engine, const MakeEngineWorld& make_world, const BodySetup& setup,
                                   SolverContext* context)
    : context_(context),
      layout_digest_(layout_digest(setup) ^ digest_of(engine)),
      model_(checked(setup)),
      weight_(setup),
      drive_(setup),
      bends_(setup),
      springs_(setup),
      all_(all_bodies(setup)),
      substeps_(static_cast<std::int64_t>(contact_substeps(setup))),
      world_(make_world(setup, model_, setup.step_s / static_cast<double>(substeps_))),
      state_(initial_kinematics(model_)) {}

void EngineBodySolver::add_forces(const AppliedLoads& applied) {
  const auto motion = as_motion_state<BlockState>(state_);
  const BlockVectors angular_velocity_rad_per_s = state_.angular_velocity_rad_per_s;
  lines_.measure(all_, motion.position_m);
  const Stage stage{all_, motion, angular_velocity_rad_per_s, lines_, applied.actuation.col(0)};
  BlockVectors force_N = applied.hydrodynamic.force_N;
  BlockVectors torque_N_m = applied.hydrodynamic.torque_N_m;
  drive_.add_loads(stage, force_N, torque_N_m);
  weight_.add_loads(stage, force_N, torque_N_m);
  bends_.add_loads(stage, force_N, torque_N_m);
  if (!world_->has_springs()) springs_.add_loads(stage, force_N, torque_N_m);
  loads_ = {applied.hydrodynamic.step, force_N, torque_N_m};
}

void EngineBodySolver::step(const AppliedLoads& applied, Kinematics& next) {
  require_matching_loads(applied, state_.step, model_.bodies(), all_.actuators.size(), driving_nodes().size());
  const double start_s = now_s();
  for (std::int64_t substep = 0; substep < substeps_; ++substep) {
    add_forces(applied);
    const double at_end = static_cast<double>(substep + 1) / static_cast<double>(substeps_);
    world_->drive((1.0 - at_end) * applied.actuation.leftCols(1) + at_end * applied.actuation.rightCols(1));
    const bool usable = loads_.force_N.allFinite() && loads_.torque_N_m.allFinite();
    if (usable) world_->advance(state_, loads_);
    if (!usable || !is_finite(state_))
      throw SolverError(
          "the motion of a body is not finite (its loads are not, or the step is too long for its springs). Look at "
          "the loads of the last steps, or use a shorter step.",
          0, state_.step);
  }
  ++state_.step;
  integration_s_ += now_s() - start_s;
  next = state_;
}

void EngineBodySolver::save(const std::string& path) {
  write_state(path, layout_digest_, state_.step, as_motion_state(state_), progress_reporter(context_),
              world_->memory());
}

void EngineBodySolver::restore(const std::string& path) {
  MotionState saved = as_motion_state(state_);
  std::vector<std::uint64_t> memory;
  const std::int64_t step = read_state(path, layout_digest_, saved, progress_reporter(context_), &memory);
  if (memory.size() != world_->memory().size())
    throw StorageError("body state '" + path + "' is of other joints. Resume with the case file that wrote it.");
  world_->restore(memory);
  state_ = {step, saved.position_m, saved.orientation_wxyz, saved.velocity_m_per_s, saved.angular_momentum_N_m_s};
}

SolverSummary EngineBodySolver::summarise() {
  SolverSummary summary;
  summary.digest = state_digest(state_.step, as_motion_state(state_), world_->memory());
  summary.seconds = {{"integrate", integration_s_}};
  return summary;
}

}  // namespace copepod::body
