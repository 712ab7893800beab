#include "mujoco/mujoco_world.hpp"

#include <array>
#include <bit>
#include <mujoco/mujoco.h>
#include <span>

#include "contract/errors.hpp"

namespace copepod::body {

namespace {

/// MuJoCo's number of what mjcf_of() calls "b3" and the like; −1: there is none.
int number_of(const mjModel& model, mjtObj type, char kind, int number) {
  return mj_name2id(&model, type, (std::string(1, kind) += std::to_string(number)).c_str());
}

/// Rows of MuJoCo's: one column of `size` numbers for each of so many.
template <int size = 3>
Eigen::Map<Eigen::Matrix<mjtNum, size, Eigen::Dynamic>> columns(mjtNum* numbers, int count) {
  return {numbers, size, count};
}

bool has_model(const BodySetup& setup) { return !setup.model.text.empty(); }

EngineUnits units_of(const BodySetup& setup, const BodyModel& model, double step_s) {
  if (has_model(setup)) return {setup.model.length_m, setup.model.mass_kg, setup.model.time_s};
  return engine_units(model, step_s / mujoco_step);
}

MujocoModel compiled_case(const BodySetup& setup, const EngineUnits& units, double step_s) {
  if (!has_model(setup)) return compiled(mjcf_of(setup, units));
  require_no_files(setup.model.text);
  return compiled(mjcf_around_model(setup, units, step_s / units.time_s), setup.model.text);
}

class MujocoWorld final : public EngineWorld {
 public:
  MujocoWorld(const BodySetup& setup, const BodyModel& model, double step_s)
      : units_(units_of(setup, model, step_s)),
        mujoco_(compiled_case(setup, units_, step_s)),
        data_(new_data(*mujoco_)),
        own_weight_N_(Eigen::Matrix3Xd::Zero(3, model.bodies())) {
    find_bodies(setup);
    find_actuators(setup);
    mj_fwdPosition(mujoco_.get(), data_.get());
    if (!has_model(setup)) set_initial_velocities(model);
    mj_step1(mujoco_.get(), data_.get());
  }

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0, 1.0}; }

  /// The acceleration that ends at the given value,
  ///   q + h (q̇ + h q̈) = s,
  /// comes from a force on the coordinate, on which no other has an effect beside its own inertia.
  void drive(const Eigen::VectorXd& values) override {
    const double h = mujoco_->opt.timestep;
    for (const Driven& driven : driven_) {
      const double way = values[driven.actuator] / driven.unit - data_->qpos[driven.coordinate];
      const double acceleration = (way / h - data_->qvel[driven.freedom]) / h;
      data_->qfrc_applied[driven.freedom] = mujoco_drive_inertia * acceleration;
    }
    for (const Control& control : controls_) data_->ctrl[control.input] = values[control.actuator];
  }

  /// One step of semi-implicit Euler in the coordinates of the trees, with soft constraints.
  /// Loads about the centres of geoms become loads about the centre of mass of their body,
  ///   F = Σ F_g,   τ = Σ τ_g + (x_g − x) × F_g
  /// @throws SolverError with MuJoCo's words if it gives up
  void advance(Kinematics& state, const Loads& loads) override {
    auto applied = columns<6>(data_->xfrc_applied, mujoco_->nbody);
    applied.setZero();
    for (Eigen::Index body = 0; body < std::ssize(geoms_); ++body) {
      const int id = mujoco_->geom_bodyid[geoms_[body]];
      const Eigen::Vector3d force = (loads.force_N.col(body) - own_weight_N_.col(body)) / units_.force_N();
      const Eigen::Vector3d arm =
          columns(data_->geom_xpos, mujoco_->ngeom).col(geoms_[body]) - columns(data_->xipos, mujoco_->nbody).col(id);
      applied.col(id).head<3>() += force;
      applied.col(id).tail<3>() += loads.torque_N_m.col(body) / units_.torque_N_m() + arm.cross(force);
    }
    mj_step2(mujoco_.get(), data_.get());
    mj_step1(mujoco_.get(), data_.get());  // places and velocities of all bodies
    require_no_warning(state.step);
    read(state);
  }

  [[nodiscard]] std::vector<std::uint64_t> memory() const override {
    std::vector<std::uint64_t> words;
    for (const std::span<double> numbers : carried())
      for (const double number : numbers) words.push_back(std::bit_cast<std::uint64_t>(number));
    return words;
  }

  void restore(std::span<const std::uint64_t> memory) override {
    for (const std::span<double> numbers : carried())
      for (double& number : numbers) {
        number = std::bit_cast<double>(memory.front());
        memory = memory.subspan(1);
      }
    mj_step1(mujoco_.get(), data_.get());
  }

 private:
  struct Driven {
    Eigen::Index actuator;
    int coordinate;  ///< number of MuJoCo's
    int freedom;     ///< of its velocity
    double unit;     ///< [m] or [rad]
  };

  struct Control {
    Eigen::Index actuator;
    int input;  ///< number of MuJoCo's
  };

  void find_bodies(const BodySetup& setup) {
    for (const BodySpecification& body : setup.bodies) motions_.push_back(body.motion);
    if (has_model(setup)) {
      const std::vector<ModelBody> bodies = bodies_of(*mujoco_, setup.model);
      require_bodies_of_model(setup, bodies);
      for (const ModelBody& body : bodies) {
        if (body.body.motion == MotionKind::free)
          own_weight_N_.col(geoms_.size()) = body.body.mass_kg * setup.gravity_m_per_s2;
        if (!setup.walls.empty() && mujoco_->geom_contype[body.geom] == 0 && mujoco_->geom_conaffinity[body.geom] == 0)
          throw CaseError("geom '" + body.body.name +
                          "' meets no wall of the case (its contype and conaffinity are 0). Set one of them to 1.");
        geoms_.push_back(body.geom);
      }
    } else {
      for (std::size_t i = 0; i < setup.bodies.size(); ++i)
        geoms_.push_back(number_of(*mujoco_, mjOBJ_GEOM, 'b', static_cast<int>(i)));
    }
  }

  void find_actuators(const BodySetup& setup) {
    for (std::size_t i = 0; i < setup.actuators.size(); ++i) {
      const ActuatorSpecification& actuator = setup.actuators[i];
      const auto row = static_cast<Eigen::Index>(i);
      if (actuator.kind == ActuatorKind::control) {
        const int input = mj_name2id(mujoco_.get(), mjOBJ_ACTUATOR, actuator.control.c_str());
        if (input < 0)
          throw CaseError("actuator " + std::to_string(i) + " of the case controls '" + actuator.control +
                          "' (the model has no actuator of this name). Name one of body.model.");
        controls_.push_back({row, input});
      }
      if (actuator.kind != ActuatorKind::joint_motion) continue;
      const int joint = number_of(*mujoco_, mjOBJ_JOINT, 'j', actuator.joint);
      if (joint < 0)
        throw CaseError("joint " + std::to_string(actuator.joint) +
                        " has a signal beside body.model (MuJoCo reads joints of the case only without a model). Drive "
                        "an actuator of the model, kind: control.");
      const bool angle = setup.joints[actuator.joint].kind == JointKind::hinge;
      driven_.push_back({row, mujoco_->jnt_qposadr[joint], mujoco_->jnt_dofadr[joint], angle ? 1.0 : units_.length_m});
    }
  }

  /// Velocities of the trees that have the momenta of the bodies, M q̇ = Σ Jᵀ (m v, I ω): those of the bodies
  /// themselves where the joints allow them.
  void set_initial_velocities(const BodyModel& model) {
    const Kinematics start = initial_kinematics(model);
    std::vector<mjtNum> momenta(mujoco_->nv, 0.0);
    for (Eigen::Index body = 0; body < std::ssize(geoms_); ++body) {
      if (motions_[body] == MotionKind::fixed) continue;
      const int id = mujoco_->geom_bodyid[geoms_[body]];
      const Eigen::Vector4d q_BP = columns<4>(mujoco_->body_iquat, mujoco_->nbody).col(id);  // of the principal axes
      const Eigen::Matrix3d R_WP = rotation_matrix(product(start.orientation_wxyz.col(body), q_BP));
      const Eigen::Vector3d momentum =
          mujoco_->body_mass[id] * start.velocity_m_per_s.col(body) / units_.velocity_m_per_s();
      const Eigen::Vector3d w_P = R_WP.transpose() * start.angular_velocity_rad_per_s.col(body) * units_.time_s;
      const Eigen::Vector3d angular_momentum =
          R_WP * columns(mujoco_->body_inertia, mujoco_->nbody).col(id).cwiseProduct(w_P);
      mj_applyFT(mujoco_.get(), data_.get(), momentum.data(), angular_momentum.data(),
                 columns(data_->xipos, mujoco_->nbody).col(id).data(), id, momenta.data());
    }
    if (mujoco_->nv > 0) mj_solveM(mujoco_.get(), data_.get(), data_->qvel, momenta.data(), 1);
  }

  /// MuJoCo continues after what it calls warnings: numbers that are not finite, contacts that do not fit.
  void require_no_warning(std::int64_t step) const {
    for (int kind = 0; kind < mjNWARNING; ++kind) {
      const mjWarningStat& warning = data_->warning[kind];
      if (warning.number > 0)
        throw SolverError("MuJoCo: " + std::string(mju_warningText(kind, warning.lastinfo)) +
                              " (the motion is too fast for the step, or too many bodies touch). Use a shorter step.",
                          0, step);
    }
  }

  void read(Kinematics& state) const {
    for (Eigen::Index body = 0; body < std::ssize(geoms_); ++body) {
      if (motions_[body] == MotionKind::fixed) continue;
      const int geom = geoms_[body];
      Eigen::Matrix<mjtNum, 6, 1> velocity;  // angular, linear
      mj_objectVelocity(mujoco_.get(), data_.get(), mjOBJ_GEOM, geom, velocity.data(), 0);
      state.position_m.col(body) = columns(data_->geom_xpos, mujoco_->ngeom).col(geom) * units_.length_m;
      const Eigen::Vector4d q_W = columns<4>(data_->xquat, mujoco_->nbody).col(mujoco_->geom_bodyid[geom]);
      const Eigen::Vector4d q_geom = columns<4>(mujoco_->geom_quat, mujoco_->ngeom).col(geom);
      state.orientation_wxyz.col(body) = of_the_same_sign(product(q_W, q_geom), state.orientation_wxyz.col(body));
      state.velocity_m_per_s.col(body) = velocity.tail<3>() * units_.velocity_m_per_s();
      state.angular_velocity_rad_per_s.col(body) = velocity.head<3>() / units_.time_s;
    }
  }

  [[nodiscard]] std::array<std::span<double>, 3> carried() const {
    const auto numbers = [](mjtNum* first, int count) { return std::span(first, static_cast<std::size_t>(count)); };
    return {numbers(data_->qpos, mujoco_->nq), numbers(data_->qvel, mujoco_->nv), numbers(data_->act, mujoco_->na)};
  }

  std::vector<MotionKind> motions_;
  EngineUnits units_;
  MujocoModel mujoco_;
  MujocoData data_;
  std::vector<int> geoms_;         ///< MuJoCo's number of each body
  Eigen::Matrix3Xd own_weight_N_;  ///< of each body, which MuJoCo adds itself: that of a model's bodies; else zero
  std::vector<Driven> driven_;
  std::vector<Control> controls_;
};

}  // namespace

std::unique_ptr<EngineWorld> make_mujoco_world(const BodySetup& setup, const BodyModel& model, double step_s) {
  return std::make_unique<MujocoWorld>(setup, model, step_s);
}

}  // namespace copepod::body
