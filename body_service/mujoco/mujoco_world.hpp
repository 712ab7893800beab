#pragma once

#include <array>
#include <span>
#include <vector>

#include "contract/body_setup.hpp"
#include "engine/engine_world.hpp"
#include "mujoco/model_bodies.hpp"

namespace copepod::body {

/// The bodies and joints of a case, or its model, in MuJoCo. Each body of the case is a geom of MuJoCo's, of which
/// several can be one rigid body.
///
/// MuJoCo carries nothing from step to step but the coordinates and velocities of its trees and the states of its
/// actuators: its constraint solver starts afresh, so that a restart gives the same bits.
class MujocoWorld final : public EngineWorld {
 public:
  /// @throws CaseError if MuJoCo cannot represent the case
  MujocoWorld(const BodySetup& setup, const BodyModel& model, double step_s);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0, 1.0}; }
  void drive(const Eigen::VectorXd& values) override;

  /// One step of semi-implicit Euler in the coordinates of the trees, with soft constraints.
  /// @throws SolverError with MuJoCo's words if it gives up
  void advance(Kinematics& state, const Loads& loads) override;
  [[nodiscard]] std::vector<std::uint64_t> memory() const override;
  void restore(std::span<const std::uint64_t> memory) override;

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

  MujocoWorld(const BodySetup& setup, const BodyModel& model, const EngineUnits& units, double step_s);

  void find_bodies(const BodySetup& setup);
  void find_actuators(const BodySetup& setup);
  [[nodiscard]] std::array<std::span<double>, 3> carried() const;
  void set_initial_velocities(const BodyModel& model);
  void require_no_warning(std::int64_t step) const;
  void read(Kinematics& state) const;

  std::vector<MotionKind> motions_;
  EngineUnits units_;
  MujocoModel mujoco_;
  MujocoData data_;
  std::vector<int> geoms_;         ///< MuJoCo's number of each body
  Eigen::Matrix3Xd own_weight_N_;  ///< of each body, which MuJoCo adds itself: that of a model's bodies; else zero
  std::vector<Driven> driven_;
  std::vector<Control> controls_;
};

}  // namespace copepod::body
