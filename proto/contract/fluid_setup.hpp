#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "contract/shape.hpp"
#include "contract/signal.hpp"

namespace copepod {

/// The method that computes the flow.
enum class FluidKind { lattice_boltzmann, stokes, vacuum };
/// What holds on a face of the domain.
enum class BoundaryKind { no_slip, periodic, free_slip, velocity, pressure, outflow };
/// Collision operator: one relaxation time, two, or central moments.
enum class CollisionKind { bgk, trt, central_moments };
/// Precision of the populations and of the arithmetic with them.
enum class Precision { double_precision, single_precision };
/// How the surface of a body acts on the fluid [theory_fluid.md].
enum class MovingBoundary { bounce_back, interpolated, central_linear, parabolic };
/// How a cell that a body uncovers gets its populations [theory_fluid.md].
enum class Refill { equilibrium, nonequilibrium, grad };

/// On a lattice, in cells per step: the scheme breaks above it. The speed of sound is 1/√3 = 0.577.
constexpr double largest_speed_lu = 0.4;

/// Condition on one face of the domain.
struct Boundary {
  BoundaryKind kind = BoundaryKind::no_slip;  ///< what holds there
  /// For BoundaryKind::velocity: of the wall; with a component through the face, of the fluid that comes in there.
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
  double pressure_Pa = 0.0;  ///< relative to rest, for BoundaryKind::pressure
  bool parabolic = false;  ///< for BoundaryKind::velocity: times 4 s(1 − s) along each axis between walls, 0 ≤ s ≤ 1
  std::optional<Signal> signal = {};  ///< for BoundaryKind::velocity: factor of it, in the middle of each step; none: 1
  std::vector<double> profile = {};   ///< likewise, in each cell of the face, the later axis fastest; none: 1
  bool removes_bodies = false;        ///< for BoundaryKind::outflow: bodies may be wholly beyond it, where no fluid is

  /// @param face  its number in FluidSetup::boundaries
  [[nodiscard]] bool lets_in(std::size_t face) const {
    return kind == BoundaryKind::velocity && velocity_m_per_s[face / 2] != 0.0;
  }
  /// [m/s]
  [[nodiscard]] Eigen::Vector3d velocity_in(std::int64_t step) const {
    return (signal ? value_of(*signal, step, 0.5) : 1.0) * velocity_m_per_s;
  }
  [[nodiscard]] double largest_speed() const {
    const auto largest = std::ranges::max_element(profile, {}, [](double factor) { return std::abs(factor); });
    return velocity_m_per_s.norm() * (signal ? largest_magnitude(*signal) : 1.0) *
           (profile.empty() ? 1.0 : std::abs(*largest));
  }  ///< of all steps and cells [m/s]
  [[nodiscard]] bool is_wall(std::size_t face) const {
    return kind == BoundaryKind::no_slip || (kind == BoundaryKind::velocity && !lets_in(face));
  }  ///< whether fluid sticks to it and none comes in
};

/// Flow before step 0.
enum class InitialFlowKind {
  rest,
  uniform,          ///< one velocity
  shear,            ///< linear between the only two walls of which one moves
  taylor_green,     ///< one vortex pair per axis: U (cos kx sin ly, −(k/l) sin kx cos ly, 0), k = 2π/Lx, l = 2π/Ly
  taylor_green_3d,  ///< U (sin kx cos ky cos kz, −cos kx sin ky cos kz, 0), k = 2π/L, in a cube
  file,             ///< cell by cell, as field output writes it
};

/// The fluid's velocity before step 0, with the pressure that belongs to it.
struct InitialFlow {
  InitialFlowKind kind = InitialFlowKind::rest;                ///< its form
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  ///< for InitialFlowKind::uniform
  double speed_m_per_s = 0.0;  ///< U, for InitialFlowKind::taylor_green, taylor_green_3d
  std::string file = {};       ///< absolute path, for InitialFlowKind::file: HDF5, read by every rank
  std::string group = {};      ///< of the file: step_000001000, mean, … or newest: of its last step
};

/// What can be written of each cell.
enum class FieldQuantity {
  density,
  velocity,
  pressure,   ///< p = c_s² (ρ − ρ₀) Δx² / Δt² [Pa], relative to fluid at rest
  vorticity,  ///< ω = ∇ × u [1/s] by central differences; zero in bodies
};

/// Field output; steps count from the start of the run. `every_steps` 0: no snapshots, otherwise step 0 has one too;
/// `mean_stop` 0: no mean. Neither quantities, region nor compression change the flow or other fields.
struct FieldOutput {
  std::string directory;                   ///< absolute; receives fields.h5, fields.xdmf and fields_mean.xdmf
  std::int64_t every_steps = 0;            ///< between two snapshots
  std::int64_t mean_start = 0;             ///< first step that enters the mean
  std::int64_t mean_stop = 0;              ///< first step that no longer does
  std::int64_t mean_every_steps = 1;       ///< one sample every so many steps
  std::vector<FieldQuantity> quantities;   ///< none: density and velocity
  std::vector<std::int64_t> region_cells;  ///< x start, x stop, y start, …: the cells that are written; stop 0: all
                                           ///< along the axis. None: the whole domain
  int compression = 0;                     ///< level of deflate, 1 to 9; 0: none
};

/// A place at which the flow is sampled.
struct Probe {
  std::string name;                                      ///< unique, for people
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< in the domain
};

/// Names of the faces of the domain, by their numbers.
constexpr std::array face_names{"x_low", "x_high", "y_low", "y_high", "z_low", "z_high"};

/// What Loads::flow holds at the start of every `every_steps`-th step; 0: nothing, ever.
struct FlowSampling {
  std::int64_t every_steps = 0;  ///< steps between two samples, the first of step 0
  bool totals = true;            ///< of all fluid; their sums do not depend on the ranks
  std::vector<Probe> probes;     ///< velocity and pressure, interpolated between the centres of cells
  /// Numbers of faces, as in FluidSetup::boundaries: volume that comes in there, and force of the fluid on it.
  std::vector<std::int64_t> faces;

  /// What the values are, in their order.
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    if (every_steps == 0) return all;
    if (totals)
      all = {"kinetic_energy_J", "dissipation_W", "enstrophy_m3_per_s2",
             "px_kg_m_per_s",    "py_kg_m_per_s", "pz_kg_m_per_s"};
    for (const Probe& probe : probes)
      for (const char* value : {".vx_m_per_s", ".vy_m_per_s", ".vz_m_per_s", ".pressure_Pa"})
        all.push_back(probe.name + value);
    for (const std::int64_t face : faces)
      for (const char* value : {".inflow_m3_per_s", ".fx_N", ".fy_N", ".fz_N"})
        all.push_back(face_names[face] + std::string(value));
    return all;
  }
  /// How many there are in a step.
  [[nodiscard]] Eigen::Index values_in(std::int64_t step) const {
    const bool is_due = every_steps > 0 && step % every_steps == 0;
    return is_due ? (totals ? 6 : 0) + 4 * static_cast<Eigen::Index>(probes.size() + faces.size()) : 0;
  }
};

/// A part of the domain that is solid and never moves; it may reach beyond the faces and into others. Films
/// leave it out.
struct ObstacleSpecification {
  std::string name;                                      ///< unique, for people
  Shape shape;                                           ///< in its own frame
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of the origin of its frame
  Eigen::Vector4d orientation_wxyz{1, 0, 0, 0};          ///< unit quaternion
  bool loads = false;  ///< Loads has them, behind those of the bodies; the torque is about position_m
};

/// Everything that a fluid solver needs before the first exchange; SI units. The domain is the box [0, domain_cells ·
/// cell_size_m]; cell (i, j, k) has its centre at ((i, j, k) + 1/2) · cell_size_m.
struct FluidSetup {
  FluidKind kind = FluidKind::lattice_boltzmann;  ///< that the case names; other solvers may ignore it
  double step_s = 0.0;                            ///< of the coupling, Δt
  double cell_size_m = 0.0;                       ///< 0 for solvers without a lattice
  double density_kg_per_m3 = 0.0;                 ///< ρ₀, at rest
  double kinematic_viscosity_m2_per_s = 0.0;      ///< ν
  std::array<std::int64_t, 3> domain_cells{};     ///< along x, y, z
  std::array<Boundary, 6> boundaries{};           ///< x low, x high, y low, y high, z low, z high
  int no_slip_plane = -1;  ///< for FluidKind::stokes: number of the one face in `boundaries` that is there; −1: none
  std::array<bool, 3> symmetry_planes{};  ///< mirror plane normal to x, y, z through the domain's middle
  Eigen::Vector3d body_force_N_per_m3 = Eigen::Vector3d::Zero();  ///< on the fluid alone
  InitialFlow initial_flow;                                       ///< before step 0
  CollisionKind collision = CollisionKind::bgk;                   ///< of a lattice
  MovingBoundary moving_boundary = MovingBoundary::bounce_back;   ///< of a lattice
  Refill refill = Refill::equilibrium;                            ///< of a lattice
  Precision precision = Precision::double_precision;              ///< of a lattice
  double film_thickness_m = 0.0;  ///< loads leave out what films that are thinner exert; 0: nothing is left out
  double wall_overlap_m = 0.0;    ///< how far moving bodies may reach beyond a face: contacts are soft
  std::vector<Shape> bodies;      ///< shapes, in the order of Kinematics and Loads
  std::vector<ObstacleSpecification> obstacles;  ///< those with loads in the order of Loads
  std::vector<BodyPair> jointed;                 ///< pairs with a joint: they may overlap, and have no film then
  FieldOutput fields;                            ///< what is written
  FlowSampling flow;                             ///< what is returned with the loads
  std::string trace_directory;                   ///< absolute; where phases are recorded; empty: nowhere
  std::string parameters = {};                   ///< JSON, of a component that the case names

  /// Of the whole domain [m]; 0 without one.
  [[nodiscard]] Eigen::Vector3d length_m() const {
    return cell_size_m * Eigen::Map<const Eigen::Matrix<std::int64_t, 3, 1>>(domain_cells.data()).cast<double>();
  }
  /// The same along periodic axes; 0: not periodic.
  [[nodiscard]] std::array<double, 3> periodic_length_m() const {
    std::array<double, 3> result{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (boundaries[2 * axis].kind == BoundaryKind::periodic) result[axis] = length_m()[axis];
    return result;
  }

  /// Columns of Loads: bodies, and obstacles with loads.
  [[nodiscard]] Eigen::Index loads() const {
    return static_cast<Eigen::Index>(bodies.size()) +
           std::ranges::count(obstacles, true, &ObstacleSpecification::loads);
  }
};

}  // namespace copepod
