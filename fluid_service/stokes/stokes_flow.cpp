#include "stokes/stokes_flow.hpp"

#include <chrono>

#include <Eigen/Cholesky>

#include "contract/errors.hpp"
#include "stokes/grand_mobility.hpp"

namespace copepod::fluid {

StokesFlow::StokesFlow(const FluidSetup& setup, const Communicator& communicator)
    : StatelessFluid("stokes", setup, communicator),
      viscosity_Pa_s_(setup.density_kg_per_m3 * setup.kinematic_viscosity_m2_per_s) {
  if (setup.no_slip_plane >= 0) plane_ = no_slip_plane_of(setup);
  for (const Shape& shape : setup.bodies) {
    if (shape.kind != ShapeKind::sphere)
      throw CaseError(
          "a body is not a sphere (solver: stokes has the mobility of spheres only). Use solver: "
          "lattice_boltzmann.");
    radius_m_.push_back(shape.radius_m);
  }
}

void StokesFlow::add_loads(const Kinematics& kinematics, Loads& loads) {
  const auto start = std::chrono::steady_clock::now();
  const Eigen::Index n = kinematics.bodies();
  Eigen::VectorXd motion(6 * n);
  motion << kinematics.velocity_m_per_s.reshaped(), kinematics.angular_velocity_rad_per_s.reshaped();
  Eigen::MatrixXd mobility = grand_mobility(kinematics.position_m, radius_m_, viscosity_Pa_s_);
  if (plane_) add_plane_images(mobility, *plane_, kinematics.position_m, radius_m_, viscosity_Pa_s_);
  const Eigen::LLT<Eigen::MatrixXd> factors(mobility);
  const Eigen::VectorXd load = factors.solve(-motion);
  if (factors.info() != Eigen::Success || !load.allFinite())
    throw SolverError(
        "the Stokes mobility cannot be inverted (positions or velocities are not finite). Use a shorter "
        "step_s.",
        0, kinematics.step);
  loads.force_N.reshaped() = load.head(3 * n);
  loads.torque_N_m.reshaped() = load.tail(3 * n);
  exchange_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

SolverSummary StokesFlow::summarise() {
  SolverSummary summary = StatelessFluid::summarise();
  summary.seconds["mobility"] = exchange_s_;
  return summary;
}

}  // namespace copepod::fluid
