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
#include "contract/words.hpp"
#include "driving/driving_protocol.hpp"

namespace copepod::coupler {

enum class FluidSolverChoice { lattice_boltzmann, stokes, vacuum, external };
enum class BodySolverChoice { own, bullet, external };
enum class BeadOrientation { parallel, perpendicular };
enum class LoadAveraging { none, two_step };

/// Whether a fluid solver of ours has neither cells nor fields.
inline bool computes_no_cells(FluidSolverChoice solver) {
  return solver == FluidSolverChoice::stokes || solver == FluidSolverChoice::vacuum;
}

/// Section `fluid` of the case: the setup that the component receives, as far as this section determines it
/// (`make_fluid_setup` adds what follows from other sections), and how the case specifies it.
struct FluidCase : FluidSetup {
  FluidSolverChoice solver = FluidSolverChoice::lattice_boltzmann;
  std::vector<std::string> command;       ///< of solver: {command: …}
  std::optional<double> relaxation_time;  ///< as given; absent where step_s was
};

/// Section `body` of the case and its gravity; `make_body_setup` adds the rest of the setup.
struct BodyCase : BodySetup {
  BodySolverChoice solver = BodySolverChoice::own;
  std::vector<std::string> command;  ///< of solver: {command: …}
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

/// Figures published for a swimmer, by their place in summary.json ("Re_bodies.B2").
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

/// A spring of the case, its bodies by name; `assemble` finds their numbers.
struct NamedSpring : SpringSpecification {
  std::array<std::string, 2> bodies;
};

/// A driving force of the case, its body by name; `assemble` finds its number.
struct NamedForce : DrivingTerm {
  std::string name;  ///< of the body
};

struct OutputCase {
  std::int64_t trajectory_every_steps = 0;  ///< 0: first and last step only
  std::int64_t trajectory_from_step = 0;    ///< no samples before but the first step
  FieldOutput fields;                       ///< its directory is that of the run
  std::int64_t checkpoint_every_steps = 0;  ///< 0: not by steps
  double checkpoint_every_wall_s = 600.0;   ///< 0: not by time
  bool wire = false;                        ///< record every message
  bool trace = false;                       ///< record what each process does when
};

/// Whether the fluid's fields are to be written at all.
inline bool wants_fields(const OutputCase& output) {
  return output.fields.every_steps > 0 || output.fields.mean_stop > 0;
}

/// Value of services.transport for a run in one process.
inline constexpr const char* in_process_transport = "in_process";

struct ServicesCase {
  int fluid_ranks = 1;
  std::vector<std::string> fluid_command;  ///< empty: the service of ours that has the chosen solver
  std::vector<std::string> body_command;
  std::string transport = "ipc";      ///< "ipc", "tcp://host:port" or "in_process"
  double connect_deadline_s = 60.0;   ///< for the Hello of each component
  double progress_deadline_s = 60.0;  ///< longest time without progress while work is due
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

/// Step of a lattice with the given relaxation time [s].
///   Δt = c_s² (τ − 1/2) Δx² / ν,   c_s² = 1/3        [docs/theory.md]
double step_from_relaxation_time(double relaxation_time, double cell_size_m, double viscosity_m2_per_s);
/// Its inverse: τ = 1/2 + ν Δt / (c_s² Δx²).
double relaxation_time_from_step(double step_s, double cell_size_m, double viscosity_m2_per_s);

/// Cells that are computed: the whole domain, halved for every symmetry plane; 0 without a lattice.
std::int64_t computed_cells(const FluidCase& fluid);
/// 19 populations per computed cell [bytes].
std::int64_t population_bytes(const FluidCase& fluid);

// The words of the case file for the coupler's own enumerators; those of the contract are in
// contract/words.hpp.

inline constexpr std::array solver_names{
    Choice<FluidSolverChoice>{"lattice_boltzmann", FluidSolverChoice::lattice_boltzmann},
    Choice<FluidSolverChoice>{"stokes", FluidSolverChoice::stokes},
    Choice<FluidSolverChoice>{"vacuum", FluidSolverChoice::vacuum},
    Choice<FluidSolverChoice>{"external", FluidSolverChoice::external}};

inline constexpr std::array body_solver_names{Choice<BodySolverChoice>{"own", BodySolverChoice::own},
                                              Choice<BodySolverChoice>{"bullet", BodySolverChoice::bullet},
                                              Choice<BodySolverChoice>{"external", BodySolverChoice::external}};

inline constexpr std::array orientation_names{Choice<BeadOrientation>{"parallel", BeadOrientation::parallel},
                                              Choice<BeadOrientation>{"perpendicular", BeadOrientation::perpendicular}};

inline constexpr std::array averaging_names{Choice<LoadAveraging>{"none", LoadAveraging::none},
                                            Choice<LoadAveraging>{"two_step", LoadAveraging::two_step}};

enum class SchemeKind { serial_explicit };
inline constexpr std::array scheme_names{Choice<SchemeKind>{"serial_explicit", SchemeKind::serial_explicit}};

inline constexpr std::array switch_names{Choice<bool>{"true", true}, Choice<bool>{"false", false}};

inline constexpr std::array axis_names{"x", "y", "z"};

/// Key path of a face by its number in the order of FluidSetup::boundaries.
inline std::string face_path(std::size_t face) {
  return std::string("fluid.boundaries.") + axis_names[face / 2] + (face % 2 == 0 ? ".low" : ".high");
}

}  // namespace copepod::coupler
