#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/shape.hpp"

namespace copepod::coupler {

enum class FluidSolverChoice { lattice_boltzmann, stokes, vacuum, external };
enum class BodySolverChoice { own, bullet, external };
enum class BeadOrientation { parallel, perpendicular };
enum class LoadAveraging { none, two_step };

/// Whether a fluid solver of ours knows neither cells nor fields.
inline bool computes_no_cells(FluidSolverChoice solver) {
  return solver == FluidSolverChoice::stokes || solver == FluidSolverChoice::vacuum;
}

/// Section `fluid` of the case; SI units, whole domain.
struct FluidCase {
  FluidSolverChoice solver = FluidSolverChoice::lattice_boltzmann;
  std::vector<std::string> command;  ///< of solver: {command: …}
  double density_kg_per_m3 = 0.0;
  double kinematic_viscosity_m2_per_s = 0.0;
  double cell_size_m = 0.0;               ///< 0: no lattice, then nothing is reported in cells
  std::optional<double> relaxation_time;  ///< as given; absent where step_s was
  std::array<std::int64_t, 3> domain_cells{};
  std::array<Boundary, 6> boundaries{};  ///< x low, x high, y low, …
  int no_slip_plane = -1;  ///< number of the face in `boundaries` that solver: stokes knows; −1: none
  std::array<bool, 3> symmetry_planes{};
  Eigen::Vector3d body_force_N_per_m3 = Eigen::Vector3d::Zero();
  CollisionKind collision = CollisionKind::bgk;
  MovingBoundary moving_boundary = MovingBoundary::bounce_back;
  Refill refill = Refill::equilibrium;
  Precision precision = Precision::double_precision;
};

/// Section `body` of the case.
struct BodyCase {
  BodySolverChoice solver = BodySolverChoice::own;
  std::vector<std::string> command;  ///< of solver: {command: …}
  Integrator integrator = Integrator::runge_kutta_4;
};

struct Bead {
  Shape shape;
  BeadOrientation orientation = BeadOrientation::parallel;  ///< of a capsule's axis to the swimmer's
};

/// Driving protocol of a swimmer [paper, eqs. (19)-(21), with the delay that its text describes].
struct Stroke {
  double amplitude_N = 0.0;
  std::int64_t period_steps = 0;
  std::int64_t phase_lag_steps = 0;
  std::int64_t cycles = 0;
};

/// Figures that somebody else found for a swimmer, by their place in summary.json ("Re_bodies.B2").
using PublishedFigures = std::vector<std::pair<std::string, double>>;

/// Three bodies and two springs; beads are trailing (B2), middle (B1), leading (B3).
struct Swimmer {
  std::string name;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< of the middle bead
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< unit vector from trailing to leading
  std::array<Bead, 3> beads;
  double bead_mass_kg = 0.0;
  std::array<double, 2> rest_gap_m{};  ///< surface to surface: B2-B1, B1-B3
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
  Stroke stroke;
  PublishedFigures published;
};

/// A spring of the case, its bodies by name.
struct NamedSpring {
  std::array<std::string, 2> bodies;
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
  double rest_length_m = 0.0;
  std::array<Eigen::Vector3d, 2> anchors_m{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
};

/// A driving force of the case: constant, or amplitude · sin(2π (t − φ)/T), acting in steps [start, stop).
struct NamedForce {
  std::string body;
  Eigen::Vector3d amplitude_N = Eigen::Vector3d::Zero();
  std::int64_t period_steps = 0;  ///< 0: constant
  std::int64_t phase_lag_steps = 0;
  std::int64_t start_step = 0;
  std::optional<std::int64_t> stop_step;  ///< absent: never
};

struct OutputCase {
  std::int64_t trajectory_every_steps = 0;        ///< 0: first and last step only
  std::int64_t trajectory_from_step = 0;          ///< no samples before but the first step
  std::int64_t fields_every_steps = 0;            ///< 0: no snapshots
  std::array<std::int64_t, 2> mean_over_steps{};  ///< [start, stop); stop 0: no mean
  std::int64_t mean_every_steps = 10;
  std::int64_t checkpoint_every_steps = 0;  ///< 0: not by steps
  double checkpoint_every_wall_s = 600.0;   ///< 0: not by time
  bool wire = false;                        ///< record every message
  bool trace = false;                       ///< record what each process does when
};

/// Whether the fluid's fields are to be written at all.
inline bool wants_fields(const OutputCase& output) {
  return output.fields_every_steps > 0 || output.mean_over_steps[1] > 0;
}

/// Value of services.transport for a run in one process.
inline constexpr const char* in_process_transport = "in_process";

struct ServicesCase {
  int fluid_ranks = 1;
  std::vector<std::string> fluid_command;  ///< empty: the service of ours that has the chosen solver
  std::vector<std::string> body_command;
  std::string transport = "ipc";      ///< "ipc", "tcp://host:port" or "in_process"
  double connect_deadline_s = 60.0;   ///< for the components to say Hello
  double progress_deadline_s = 60.0;  ///< a component may stand still for so long while work is due
};

/// One key of the case that takes several values, one run each.
struct Sweep {
  std::string key;                  ///< key path
  std::vector<std::string> values;  ///< as written
};

/// A complete case with every default filled in.
struct Case {
  std::string name;
  std::string parameter_set;  ///< label; empty: none
  FluidCase fluid;
  std::optional<double> given_step_s;  ///< absent where the relaxation time was given
  double step_s = 0.0;                 ///< given or derived
  BodyCase body;
  Eigen::Vector3d gravity_m_per_s2 = Eigen::Vector3d::Zero();
  std::vector<Swimmer> swimmers;
  std::vector<BodySpecification> bodies;  ///< those not of swimmers
  std::vector<NamedSpring> springs;
  std::vector<NamedForce> forces;
  LoadAveraging load_averaging = LoadAveraging::two_step;
  std::int64_t steps = 0;
  OutputCase output;
  ServicesCase services;
  std::optional<Sweep> sweep;  ///< absent in each of its members
};

}  // namespace copepod::coupler
