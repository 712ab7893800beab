#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "contract/controller.hpp"
#include "driving/driving_protocol.hpp"

namespace copepod::coupler {

/// A controller and what it is joined to.
struct AttachedController {
  std::unique_ptr<Controller> controller;
  std::int64_t every_steps = 1;
  std::vector<Eigen::Index> bodies;  ///< that it observes
  struct Actuator {
    std::size_t number = 0;  ///< in the drive
    double factor = 1.0;     ///< stiffness where a rest length acts as a force
    bool moves = false;      ///< until the next action, instead of at once
  };
  std::vector<Actuator> actuators;
  Eigen::Index flow = 0;  ///< values of a sample
};

/// Asks the controllers of a case in the steps of theirs, one after the other, and steers the drive.
class Controllers {
 public:
  /// None.
  Controllers() = default;
  /// @param driving  outlives this object
  Controllers(std::vector<AttachedController> controllers, DrivingProtocol& driving)
      : controllers_(std::move(controllers)), driving_(&driving) {}

  /// @param kinematics  of all bodies at the start of the step
  /// @param loads       hydrodynamic, on all of them during the step before
  void act(const Kinematics& kinematics, const Loads& loads) {
    for (AttachedController& each : controllers_) {
      if (kinematics.step % each.every_steps != 0) continue;
      observe(each.bodies, kinematics, loads);
      observation_.loads.flow = loads.flow;
      if (loads.flow.size() == 0) observation_.loads.flow.setZero(each.flow);
      const std::vector<double> action = each.controller->act(observation_);
      for (std::size_t i = 0; i < action.size(); ++i) {
        const auto& [number, factor, moves] = each.actuators[i];
        driving_->steer(number, kinematics.step, factor * action[i], moves ? each.every_steps : 0);
      }
    }
  }

  [[nodiscard]] const std::vector<AttachedController>& all() const { return controllers_; }

 private:
  void observe(const std::vector<Eigen::Index>& bodies, const Kinematics& kinematics, const Loads& loads) {
    Kinematics& seen = observation_.kinematics;
    seen.step = kinematics.step;
    seen.position_m = kinematics.position_m(Eigen::all, bodies);
    seen.orientation_wxyz = kinematics.orientation_wxyz(Eigen::all, bodies);
    seen.velocity_m_per_s = kinematics.velocity_m_per_s(Eigen::all, bodies);
    seen.angular_velocity_rad_per_s = kinematics.angular_velocity_rad_per_s(Eigen::all, bodies);
    observation_.loads.step = kinematics.step - 1;
    observation_.loads.force_N = loads.force_N(Eigen::all, bodies);
    observation_.loads.torque_N_m = loads.torque_N_m(Eigen::all, bodies);
  }

  std::vector<AttachedController> controllers_;
  DrivingProtocol* driving_ = nullptr;
  Observation observation_;
};

}  // namespace copepod::coupler
