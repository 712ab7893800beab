#include "constant_drag_fluid.hpp"

#include <numbers>

#include "counter_file.hpp"

namespace copepod::doubles {

ConstantDragFluid::ConstantDragFluid(const FluidSetup& setup)
    : viscosity_Pa_s_(setup.density_kg_per_m3 * setup.kinematic_viscosity_m2_per_s) {
  for (const Shape& shape : setup.bodies) radius_m_.push_back(shape.radius_m);
}

void ConstantDragFluid::exchange(const Kinematics& kinematics, Loads& loads) {
  constexpr double pi = std::numbers::pi;
  loads.resize(kinematics.bodies());
  loads.step = kinematics.step;
  Digest digest(digest_);
  for (Eigen::Index body = 0; body < kinematics.bodies(); ++body) {
    const double r = radius_m_.at(static_cast<std::size_t>(body));
    loads.force_N.col(body) = -6 * pi * viscosity_Pa_s_ * r * kinematics.velocity_m_per_s.col(body);
    loads.torque_N_m.col(body) =
        -8 * pi * viscosity_Pa_s_ * r * r * r * kinematics.angular_velocity_rad_per_s.col(body);
    for (const double coordinate : kinematics.position_m.col(body)) digest.add(coordinate);
  }
  digest_ = digest.value();
}

void ConstantDragFluid::advance() { ++steps_; }

void ConstantDragFluid::save(const std::string& path) { write_counters(path, {steps_, digest_}); }

void ConstantDragFluid::restore(const std::string& path) {
  const auto counters = read_counters(path);
  steps_ = counters[0];
  digest_ = counters[1];
}

SolverSummary ConstantDragFluid::summarise() { return {digest_, steps_, 1, {{"bulk", 0.0}}}; }

}  // namespace copepod::doubles
