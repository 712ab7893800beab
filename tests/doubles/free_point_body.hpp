#pragma once

#include <vector>

#include "geometry/actuator_loads.hpp"
#include "point_bodies.hpp"

namespace copepod::doubles {

/// Masses that move under hydrodynamic forces and the drive's; torques are neglected, angular velocities are kept.
///   v(n+1) = v(n) + (F + F_drive) h / m,   x(n+1) = x(n) + h v(n+1)         semi-implicit Euler
/// In a ConstantDragFluid without driving: v(n) = v(0) (1 − 6π η r h / m)^n.
class FreePointBody final : public PointBodies {
 public:
  explicit FreePointBody(const BodySetup& setup) : PointBodies(setup), actuators_(setup.actuators) {
    for (const BodySpecification& body : setup.bodies) mass_kg_.push_back(body.mass_kg);
  }

 private:
  void accelerate(const AppliedLoads& applied, Kinematics& state) override {
    drive_loads(actuators_, applied.actuation.col(0), state, drive_);
    for (Eigen::Index body = 0; body < state.bodies(); ++body) {
      const double h_over_m = step_s() / mass_kg_[static_cast<std::size_t>(body)];
      state.velocity_m_per_s.col(body) +=
          h_over_m * (applied.hydrodynamic.force_N.col(body) + drive_.force_N.col(body));
    }
  }

  std::vector<double> mass_kg_;
  std::vector<ActuatorSpecification> actuators_;
  Loads drive_;
};

}  // namespace copepod::doubles
