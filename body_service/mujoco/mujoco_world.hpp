#pragma once

#include <memory>
#include <vector>

#include "contract/body_setup.hpp"
#include "engine/engine_units.hpp"
#include "engine/engine_world.hpp"

struct mjModel_;
struct mjData_;

namespace copepod::body {

/// The bodies and joints of a case in MuJoCo.
///
/// MuJoCo carries nothing from step to step but the coordinates and velocities of its trees: its constraint solver
/// starts afresh, so that a restart gives the same bits.
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

  void set_initial_velocities(const BodyModel& model);
  void require_no_warning(std::int64_t step) const;
  void read(Kinematics& state) const;

  std::vector<MotionKind> motions_;
  EngineUnits units_;
  std::unique_ptr<mjModel_, void (*)(mjModel_*)> mujoco_;
  std::unique_ptr<mjData_, void (*)(mjData_*)> data_;
  std::vector<int> ids_;  ///< MuJoCo's number of each body
  std::vector<Driven> driven_;
};

}  // namespace copepod::body
