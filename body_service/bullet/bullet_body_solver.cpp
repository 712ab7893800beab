#include "bullet/bullet_body_solver.hpp"

#include <chrono>

#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "request_checks.hpp"
#include "storage/state_file.hpp"

namespace copepod::body {

namespace {

const BodySetup& checked(const BodySetup& setup) {
  require_positive_step(setup.step_s);
  return setup;
}

/// One block, as Bullet moves all bodies together.
BodyBlock all_bodies(const BodySetup& setup) {
  const auto blocks = independent_blocks(setup, static_cast<Eigen::Index>(setup.bodies.size()));
  return blocks.empty() ? BodyBlock{} : blocks.front();
}

bool all_finite(const BulletState& state) {
  return state.position_m.allFinite() && state.orientation_wxyz.allFinite() && state.velocity_m_per_s.allFinite() &&
         state.angular_velocity_rad_per_s.allFinite();
}

}  // namespace

Capabilities bullet_capabilities() {
  return {"Bullet rigid bodies",
          COPEPOD_VERSION,
          {"shape:sphere", "shape:capsule", "motion:free", "motion:fixed", "motion:prescribed", "motion:axis",
           "springs", "anchors", "bends", "actuator:pair_force", "actuator:body_force", "actuator:body_torque",
           "actuator:world_force", "actuator:world_torque", "gravity", "contacts", "checkpoint"}};
}

BulletBodySolver::BulletBodySolver(const BodySetup& setup, SolverContext* context)
    : context_(context),
      layout_digest_(mix_bits(layout_digest(setup))),
      model_(checked(setup)),
      weight_(setup),
      drive_(setup),
      bends_(setup),
      all_(all_bodies(setup)),
      world_(setup, model_),
      state_(initial_state(model_)) {}

void BulletBodySolver::kinematics(Kinematics& kinematics) {
  kinematics.step = step_;
  kinematics.position_m = state_.position_m;
  kinematics.orientation_wxyz = state_.orientation_wxyz;
  kinematics.velocity_m_per_s = state_.velocity_m_per_s;
  kinematics.angular_velocity_rad_per_s = state_.angular_velocity_rad_per_s;
}

void BulletBodySolver::step(const AppliedLoads& applied, Kinematics& next) {
  require_matching_loads(applied, step_, model_.bodies(), static_cast<Eigen::Index>(all_.actuators.size()), 1);
  const auto start = std::chrono::steady_clock::now();
  const MotionState motion = as_motion_state(state_);
  const Stage stage{all_, motion, state_.angular_velocity_rad_per_s, applied.actuation.col(0)};
  loads_ = applied.hydrodynamic;
  for (const ForceElement* element :
       {static_cast<const ForceElement*>(&drive_), static_cast<const ForceElement*>(&weight_),
        static_cast<const ForceElement*>(&bends_)})
    element->add_loads(stage, loads_.force_N, loads_.torque_N_m);
  const bool usable = loads_.force_N.allFinite() && loads_.torque_N_m.allFinite();
  if (usable) world_.advance(state_, loads_.force_N, loads_.torque_N_m);
  if (!usable || !all_finite(state_))
    throw SolverError(
        "the motion of a body is not finite (its loads are not, or the step is too long for its springs). "
        "Look at the loads of the last steps, or use a shorter step.",
        0, step_);
  ++step_;
  integration_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  kinematics(next);
}

std::function<void()> BulletBodySolver::report_progress() const {
  if (context_ == nullptr) return {};
  return [this] { context_->report_progress(); };
}

void BulletBodySolver::save(const std::string& path) {
  write_state(path, {layout_digest_, step_}, as_motion_state(state_), report_progress());
}

void BulletBodySolver::restore(const std::string& path) {
  MotionState saved = as_motion_state(state_);
  step_ = read_state(path, layout_digest_, saved, report_progress());
  state_ = {saved.position_m, saved.orientation_wxyz, saved.velocity_m_per_s, saved.angular_momentum_N_m_s};
}

SolverSummary BulletBodySolver::summarise() {
  SolverSummary summary;
  summary.digest = state_digest(step_, as_motion_state(state_));
  summary.seconds = {{"integrate", integration_s_}};
  return summary;
}

}  // namespace copepod::body
