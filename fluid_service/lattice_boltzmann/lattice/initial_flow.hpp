#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/lattice/lattice_units.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"
#include "ranks/block_partition.hpp"

// Where the populations start. All quantities are in lattice units.

namespace copepod::fluid {

/// Macroscopic state of one cell.
struct LocalFlow {
  double excess_density = 0.0;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();  ///< ∂u_i/∂x_j, without trace
  Eigen::Vector3d force = Eigen::Vector3d::Zero();     ///< of the body force, per cell
};

/// Deviation f̃_α − w_α of a population after the collision, of second order in the cell:
///   f̃_α = f_α^eq − 3 w_α ρ (τ − 1) Σ_ij e_i e_j ∂u_i/∂x_j + 3 w_α e·F/2                    (F14)
/// from f_α^neq = −3 w_α ρ τ e·(e·∇)u, of which the collision leaves the part 1 − 1/τ [Skordos 1993], and with the half
/// of the force F that a collision has already added for the half step to come [Guo, Zheng, Shi 2002].
inline double starting_deviation(int alpha, const LocalFlow& flow, double relaxation_time) {
  const auto& e = d3q19::e[alpha];
  const Eigen::Vector3d direction(e[0], e[1], e[2]);
  const double velocity[3] = {flow.velocity[0], flow.velocity[1], flow.velocity[2]};
  return equilibrium_deviation(alpha, flow.excess_density, velocity) -
         3.0 * d3q19::weight(alpha) * (1.0 + flow.excess_density) * (relaxation_time - 1.0) *
             direction.dot(flow.gradient * direction) +
         1.5 * d3q19::weight(alpha) * direction.dot(flow.force);
}

/// Linear between the two walls of which one moves, whose axis is the only one with a moving wall.
inline LocalFlow shear_flow(const FluidSetup& setup, const LatticeUnits& units, const Eigen::Vector3d& centre) {
  LocalFlow flow;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Boundary& low = setup.boundaries[2 * axis];
    const Boundary& high = setup.boundaries[2 * axis + 1];
    if (low.kind != BoundaryKind::velocity && high.kind != BoundaryKind::velocity) continue;
    const Eigen::Vector3d low_lu = units.velocity_lu(low.velocity_m_per_s);
    flow.gradient.col(axis) =
        (units.velocity_lu(high.velocity_m_per_s) - low_lu) / static_cast<double>(setup.domain_cells[axis]);
    flow.velocity = low_lu + centre[axis] * flow.gradient.col(axis);
    break;
  }
  return flow;
}

/// u = U (cos kx sin ly, −(k/l) sin kx cos ly, 0),   p = −ρU²/4 (cos 2kx + (k/l)² cos 2ly)
/// [Taylor & Green 1937], one wavelength in each direction.
inline LocalFlow taylor_green_flow(const FluidSetup& setup, const LatticeUnits& units, const Eigen::Vector3d& centre) {
  const double speed = units.velocity_lu({setup.initial_flow.speed_m_per_s, 0.0, 0.0}).x();
  const double k = 2.0 * std::numbers::pi / static_cast<double>(setup.domain_cells[0]);
  const double l = 2.0 * std::numbers::pi / static_cast<double>(setup.domain_cells[1]);
  const double x = k * centre.x();
  const double y = l * centre.y();
  LocalFlow flow;
  flow.velocity = {speed * std::cos(x) * std::sin(y), -speed * (k / l) * std::sin(x) * std::cos(y), 0.0};
  flow.gradient(0, 0) = -speed * k * std::sin(x) * std::sin(y);
  flow.gradient(0, 1) = speed * l * std::cos(x) * std::cos(y);
  flow.gradient(1, 0) = -speed * (k * k / l) * std::cos(x) * std::cos(y);
  flow.gradient(1, 1) = -flow.gradient(0, 0);
  const double pressure = -0.25 * speed * speed * (std::cos(2.0 * x) + (k / l) * (k / l) * std::cos(2.0 * y));
  flow.excess_density = 3.0 * pressure;
  return flow;
}

/// u = U (sin kx cos ky cos kz, −cos kx sin ky cos kz, 0),   p = ρU²/16 (cos 2kx + cos 2ky)(cos 2kz + 2)
/// [Taylor & Green 1937], one wavelength along each edge of a cube.
inline LocalFlow taylor_green_flow_3d(const FluidSetup& setup, const LatticeUnits& units,
                                      const Eigen::Vector3d& centre) {
  const double speed = units.velocity_lu({setup.initial_flow.speed_m_per_s, 0.0, 0.0}).x();
  const double k = 2.0 * std::numbers::pi / static_cast<double>(setup.domain_cells[0]);
  const Eigen::Array3d c = (k * centre).array().cos();
  const Eigen::Array3d s = (k * centre).array().sin();
  LocalFlow flow;
  flow.velocity = speed * c.z() * Eigen::Vector3d(s.x() * c.y(), -c.x() * s.y(), 0.0);
  flow.gradient.row(0) = speed * k * Eigen::RowVector3d(c.prod(), -s.x() * s.y() * c.z(), -s.x() * c.y() * s.z());
  flow.gradient.row(1) = speed * k * Eigen::RowVector3d(s.x() * s.y() * c.z(), -c.prod(), c.x() * s.y() * s.z());
  const Eigen::Array3d twice = (2.0 * k * centre).array().cos();
  flow.excess_density = 3.0 / 16.0 * speed * speed * (twice.x() + twice.y()) * (twice.z() + 2.0);
  return flow;
}

/// The flow that a setup starts with, in one cell of the whole domain.
inline LocalFlow initial_flow(const FluidSetup& setup, const LatticeUnits& units, const Cell& cell) {
  const Eigen::Vector3d centre(static_cast<double>(cell[0]) + 0.5, static_cast<double>(cell[1]) + 0.5,
                               static_cast<double>(cell[2]) + 0.5);
  switch (setup.initial_flow.kind) {
    case InitialFlowKind::rest:
    case InitialFlowKind::file:  // needs the neighbours [LatticeBoltzmann]
      break;
    case InitialFlowKind::uniform:
      return {0.0, units.velocity_lu(setup.initial_flow.velocity_m_per_s)};
    case InitialFlowKind::shear:
      return shear_flow(setup, units, centre);
    case InitialFlowKind::taylor_green:
      return taylor_green_flow(setup, units, centre);
    case InitialFlowKind::taylor_green_3d:
      return taylor_green_flow_3d(setup, units, centre);
  }
  return {};
}

}  // namespace copepod::fluid
