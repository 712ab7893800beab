#include "mujoco/mujoco_world.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <mujoco/mujoco.h>
#include <span>
#include <string>

#include "contract/errors.hpp"
#include "mujoco/mjcf.hpp"

namespace copepod::body {

namespace {

/// MuJoCo's own handler would wait for a key; an exception passes its C functions, which hold nothing.
[[noreturn]] void raise(const char* text) {
  throw SolverError("MuJoCo: " + std::string(text) + " (an error inside the library). Use body.solver: own.", 0);
}

void ignore(const char*) {}  // its own handler writes a file; require_no_warning() looks for warnings

using Model = std::unique_ptr<mjModel, void (*)(mjModel*)>;

/// @throws CaseError with MuJoCo's words if it refuses the text
Model compiled(const std::string& mjcf) {
  mju_user_error = raise;
  mju_user_warning = ignore;
  constexpr const char* name = "case.xml";
  std::array<char, 1000> problem{};
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), name, static_cast<int>(mjcf.size()));
  std::memcpy(files->filedata[0], mjcf.data(), mjcf.size());
  Model model(mj_loadXML(name, files.get(), problem.data(), static_cast<int>(problem.size())), mj_deleteModel);
  mj_deleteVFS(files.get());
  if (model == nullptr)
    throw CaseError("MuJoCo refuses the bodies (" + std::string(problem.data()) + "). Use body.solver: own.");
  return model;
}

/// MuJoCo's number of what mjcf_of() calls "b3" and the like; −1: there is none.
int number_of(const mjModel& model, mjtObj type, char kind, int number) {
  return mj_name2id(&model, type, (std::string(1, kind) += std::to_string(number)).c_str());
}

/// Rows of MuJoCo's: one column of `size` numbers per body.
template <int size = 3>
Eigen::Map<Eigen::Matrix<mjtNum, size, Eigen::Dynamic>> columns(mjtNum* numbers, const mjModel& model) {
  return {numbers, size, model.nbody};
}

}  // namespace

MujocoWorld::MujocoWorld(const BodySetup& setup, const BodyModel& model, double step_s)
    : units_(engine_units(model, step_s / mujoco_step)),
      mujoco_(compiled(mjcf_of(setup, units_))),
      data_(mj_makeData(mujoco_.get()), mj_deleteData) {
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
    motions_.push_back(setup.bodies[i].motion);
    ids_.push_back(number_of(*mujoco_, mjOBJ_BODY, 'b', static_cast<int>(i)));
  }
  for (std::size_t i = 0; i < setup.actuators.size(); ++i) {
    const ActuatorSpecification& actuator = setup.actuators[i];
    if (actuator.kind != ActuatorKind::joint_motion) continue;
    const int joint = number_of(*mujoco_, mjOBJ_JOINT, 'j', actuator.joint);
    const bool angle = setup.joints[static_cast<std::size_t>(actuator.joint)].kind == JointKind::hinge;
    driven_.push_back({static_cast<Eigen::Index>(i), mujoco_->jnt_qposadr[joint], mujoco_->jnt_dofadr[joint],
                       angle ? 1.0 : units_.length_m});
  }
  mj_fwdPosition(mujoco_.get(), data_.get());
  set_initial_velocities(model);
  mj_step1(mujoco_.get(), data_.get());
}

/// Velocities of the trees that have the momenta of the bodies, M q̇ = Σ Jᵀ (m v, I ω): those of the bodies themselves
/// where the joints allow them.
void MujocoWorld::set_initial_velocities(const BodyModel& model) {
  const Kinematics start = initial_kinematics(model);
  std::vector<mjtNum> momenta(static_cast<std::size_t>(mujoco_->nv), 0.0);
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (motions_[i] == MotionKind::fixed) continue;
    const auto body = static_cast<Eigen::Index>(i);
    const int id = ids_[i];
    const Eigen::Matrix3d R_WB = rotation_matrix(start.orientation_wxyz.col(body));
    const Eigen::Vector3d momentum =
        mujoco_->body_mass[id] * start.velocity_m_per_s.col(body) / units_.velocity_m_per_s();
    const Eigen::Vector3d w_B = R_WB.transpose() * start.angular_velocity_rad_per_s.col(body) * units_.time_s;
    const Eigen::Vector3d angular_momentum = R_WB * columns(mujoco_->body_inertia, *mujoco_).col(id).cwiseProduct(w_B);
    mj_applyFT(mujoco_.get(), data_.get(), momentum.data(), angular_momentum.data(),
               columns(data_->xipos, *mujoco_).col(id).data(), id, momenta.data());
  }
  if (mujoco_->nv > 0) mj_solveM(mujoco_.get(), data_.get(), data_->qvel, momenta.data(), 1);
}

/// The acceleration that ends at the given value,
///   q + h (q̇ + h q̈) = s,
/// comes from a force on the coordinate, on which no other has an effect beside its own inertia.
void MujocoWorld::drive(const Eigen::VectorXd& values) {
  const double h = mujoco_->opt.timestep;
  for (const Driven& driven : driven_) {
    const double way = values[driven.actuator] / driven.unit - data_->qpos[driven.coordinate];
    const double acceleration = (way / h - data_->qvel[driven.freedom]) / h;
    data_->qfrc_applied[driven.freedom] = mujoco_drive_inertia * acceleration;
  }
}

void MujocoWorld::advance(Kinematics& state, const Loads& loads) {
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const auto body = static_cast<Eigen::Index>(i);
    auto load = columns<6>(data_->xfrc_applied, *mujoco_).col(ids_[i]);
    load.head<3>() = loads.force_N.col(body) / units_.force_N();
    load.tail<3>() = loads.torque_N_m.col(body) / units_.torque_N_m();
  }
  mj_step2(mujoco_.get(), data_.get());
  mj_step1(mujoco_.get(), data_.get());  // places and velocities of all bodies
  require_no_warning(state.step);
  read(state);
}

/// MuJoCo continues after what it calls warnings: numbers that are not finite, contacts that do not fit.
void MujocoWorld::require_no_warning(std::int64_t step) const {
  for (int kind = 0; kind < mjNWARNING; ++kind) {
    const mjWarningStat& warning = data_->warning[kind];
    if (warning.number > 0) {
      throw SolverError("MuJoCo: " + std::string(mju_warningText(kind, warning.lastinfo)) +
                            " (the motion is too fast for the step, or too many bodies touch). Use a shorter step.",
                        0, step);
    }
  }
}

void MujocoWorld::read(Kinematics& state) const {
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (motions_[i] == MotionKind::fixed) continue;
    const auto body = static_cast<Eigen::Index>(i);
    const int id = ids_[i];
    Eigen::Matrix<mjtNum, 6, 1> velocity;  // angular, linear
    mj_objectVelocity(mujoco_.get(), data_.get(), mjOBJ_BODY, id, velocity.data(), 0);
    state.position_m.col(body) = columns(data_->xipos, *mujoco_).col(id) * units_.length_m;
    state.orientation_wxyz.col(body) =
        of_the_same_sign(columns<4>(data_->xquat, *mujoco_).col(id), state.orientation_wxyz.col(body));
    state.velocity_m_per_s.col(body) = velocity.tail<3>() * units_.velocity_m_per_s();
    state.angular_velocity_rad_per_s.col(body) = velocity.head<3>() / units_.time_s;
  }
}

std::vector<std::uint64_t> MujocoWorld::memory() const {
  std::vector<std::uint64_t> words;
  for (const auto& numbers : {std::span(data_->qpos, mujoco_->nq), std::span(data_->qvel, mujoco_->nv)})
    for (const mjtNum number : numbers) words.push_back(std::bit_cast<std::uint64_t>(number));
  return words;
}

void MujocoWorld::restore(std::span<const std::uint64_t> memory) {
  for (const auto& numbers : {std::span(data_->qpos, mujoco_->nq), std::span(data_->qvel, mujoco_->nv)}) {
    for (mjtNum& number : numbers) {
      number = std::bit_cast<mjtNum>(memory.front());
      memory = memory.subspan(1);
    }
  }
  mj_step1(mujoco_.get(), data_.get());
}

}  // namespace copepod::body
