#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/controller.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/shape.hpp"
#include "contract/words.hpp"
#include "driving/driving_protocol.hpp"

namespace copepod::coupler {

enum class FluidSolverChoice { lattice_boltzmann, stokes, vacuum, external };
enum class BodySolverChoice { own, bullet, mujoco, external };
enum class BeadOrientation { parallel, perpendicular };
enum class LoadAveraging { none, two_step };

/// Whether a fluid solver of ours has neither cells nor fields.
inline bool computes_no_cells(FluidSolverChoice solver) {
  return solver == FluidSolverChoice::stokes || solver == FluidSolverChoice::vacuum;
}

/// Section `fluid` of the case: the setup that the component receives, as far as this section determines it
/// (`make_fluid_setup` adds what follows from other sections), and how the case specifies it.
struct FluidCase : FluidSetup {
  FluidCase() {  // what a case gets that names no schemes
    collision = CollisionKind::trt;
    moving_boundary = MovingBoundary::parabolic;
    refill = Refill::nonequilibrium;
  }
  FluidSolverChoice solver = FluidSolverChoice::lattice_boltzmann;
  std::vector<std::string> command;       ///< of solver: {command: …}
  std::optional<double> relaxation_time;  ///< as given; absent where step_s was
};

/// Section `body` of the case and its gravity; `make_body_setup` adds the rest of the setup.
struct BodyCase : BodySetup {
  BodySolverChoice solver = BodySolverChoice::own;
  std::vector<std::string> command;  ///< of solver: {command: …}
  std::string model_file;            ///< path; its bodies are still to be read. Empty: none
};

/// A body as the case has it: shape and place are those of the shape's own frame.
struct GivenBody : BodySpecification {
  Eigen::Vector3d center_of_mass_m = Eigen::Vector3d::Zero();  ///< in that frame, beside an inertia
};

using Bead = GivenBody;  ///< of a swimmer, in the swimmer's frame; its body is called "swimmer.bead"

/// Extent of a bead along the swimmer's z axis [m]: 2r + |d_z| L, d the direction of a capsule.
double extent_along_m(const Bead& bead);

/// What drives two bodies along the line between them: a force that pushes them apart, or their spring's rest length.
enum class DriveKind { pair_force, rest_length };

struct Drive {
  DriveKind kind = DriveKind::pair_force;
  Signal signal;  ///< [N] or [m]
};

/// A spring between the centres of two beads, whose numbers stand for bodies, and what drives it.
struct Arm : SpringSpecification {
  std::optional<Drive> drive;
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

/// What the three-bead shorthand holds beyond the beads and arms that it stands for: B2 (trailing), B1 (middle), B3
/// (leading) in a row along z, all of one mass, arms of one spring.
struct ThreeBeads {
  Eigen::Vector2d rest_gap_m = Eigen::Vector2d::Zero();  ///< surface to surface: B2-B1, B1-B3
  Stroke stroke;
};

/// Beads, the arms between them and what drives the arms. The swimmer's own axis is its z axis.
struct Swimmer {
  std::string name;
  std::vector<Bead> beads;
  std::vector<Arm> arms;
  std::vector<BendSpecification> bends;                ///< between beads, by their numbers here
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< origin of the swimmer's frame
  Eigen::Vector4d orientation_wxyz{1, 0, 0, 0};        ///< of its frame in the world
  double phase_deg = 0.0;                              ///< its drive runs late by that part of each signal's period
  std::optional<ThreeBeads> three_beads;               ///< where the case uses the shorthand
  PublishedFigures published;
  bool is_of_swarm = false;  ///< placed by section `swarm`, after those of section `swimmers`
};

/// A body that is not of a swimmer.
struct SingleBody : GivenBody {
  std::optional<Signal> signal;  ///< by which its prescribed velocities vary in time
};

// Items of the case that name their bodies; `assemble` finds the numbers.

struct NamedSpring : SpringSpecification {
  std::vector<std::string> bodies;  ///< two
};

struct NamedBend : BendSpecification {
  std::vector<std::string> bodies;  ///< three, the vertex in the middle
};

/// A joint; where its bodies start determines what it keeps. Its axis is that at the start, in the world; its two
/// anchors are those of a rod only.
struct NamedJoint : JointSpecification {
  static constexpr const char* world = "world";

  std::string name;
  std::vector<std::string> bodies;                     ///< two, one may be `world`
  Eigen::Vector3d anchor_m = Eigen::Vector3d::Zero();  ///< at the start, in the world
  std::optional<Signal> signal;                        ///< of the first body relative to the second
};

/// An actuator of the case and how its value varies.
struct NamedActuator : ActuatorSpecification {
  std::vector<std::string> bodies;  ///< two of a pair, none of a control, otherwise one
  bool rest_length = false;         ///< the signal is the rest length of the spring between them [m]
  Signal signal;
};

/// Bodies whose motion is measured together, like that of a swimmer.
struct NamedGroup {
  std::string name;
  std::vector<std::string> bodies;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< own axis at the start, in the world
  std::int64_t period_steps = 0;                    ///< of the cycles to measure; 0: that of the drive
};

/// A component that observes bodies and steers actuators; the names of both are those of the case.
struct ControllerCase : ControllerSetup {
  std::vector<std::string> command;
};

/// What lubrication theory adds to the fluid's loads; its cut-off becomes FluidSetup::film_thickness_m.
struct LubricationCase {
  /// Thickness of the films; 0: none; absent: auto, with fluids that announce thin_films.
  std::optional<double> cut_off_cells;
  double roughness_m = 1e-9;  ///< films do not get thinner
};

/// When a run may end before its last step.
struct Periodicity {
  double tolerance = 1e-3;  ///< change of every swimmer's motion from one cycle to the next, relative to it
  std::int64_t cycles = 0;  ///< the most of them, which bounds the steps of the case; 0: no bound
};

/// Section `contact`: bodies that meet each other or a wall rebound.
struct ContactCase {
  double restitution = 0.9;
  double friction = 0.3;
  std::optional<double> wall_friction;      ///< absent: as between bodies
  std::optional<double> stiffness_N_per_m;  ///< absent: by the rule of setups.hpp
};

/// Drag and lift of a body or obstacle as coefficients [analysis/coefficients.hpp].
struct Coefficients {
  std::string of;
  double speed_m_per_s = 0.0;
  double area_m2 = 0.0;
  double length_m = 0.0;
  Eigen::Vector3d drag_axis = Eigen::Vector3d::UnitX();
  Eigen::Vector3d lift_axis = Eigen::Vector3d::UnitY();
  std::int64_t from_step = 0;  ///< first that is evaluated
};

enum class TrajectoryFormat { by_bodies, csv, npy };

struct OutputCase {
  OutputCase() { fields.mean_every_steps = 10; }
  std::int64_t trajectory_every_steps = 100;                         ///< 0: first and last step only
  std::int64_t trajectory_from_step = 0;                             ///< no samples before but the first step
  TrajectoryFormat trajectory_format = TrajectoryFormat::by_bodies;  ///< settled once the bodies are known
  std::int64_t bodies_every_steps = 0;                               ///< 0: no surfaces of the bodies
  FieldOutput fields;                                                ///< its directory is that of the run
  FlowSampling flow;
  bool writes_flow = true;          ///< its samples, to flow.csv
  std::int64_t flow_from_step = 0;  ///< first that is evaluated
  std::vector<Coefficients> coefficients;
  std::int64_t checkpoint_every_steps = 0;  ///< 0: not by steps
  double checkpoint_every_wall_s = 600.0;   ///< 0: not by time
  bool wire = false;                        ///< record every message
  bool trace = false;                       ///< record what each process does when
};

/// Value of services.transport for a run in one process.
inline constexpr const char* in_process_transport = "in_process";

struct ServicesCase {
  int fluid_ranks = 1;
  std::vector<std::string> fluid_command;  ///< empty: the service of ours that has the chosen solver
  std::vector<std::string> body_command;
  std::string fluid_parameters;  ///< JSON, of a component that replaces ours
  std::string body_parameters;
  int body_threads = 1;
  std::vector<std::string> hosts;     ///< "name" or "name:ranks"; the first has coupler and bodies; empty: this machine
  std::string transport = "ipc";      ///< "ipc", "tcp://host:port" or "in_process"
  double connect_deadline_s = 60.0;   ///< for the Hello of each component
  double progress_deadline_s = 60.0;  ///< longest time without progress while work is due
  double silence_s = 3.0;             ///< longest time without an answer to a ping
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
  std::vector<SingleBody> bodies;
  std::vector<NamedSpring> springs;
  std::vector<NamedBend> bends;
  std::vector<NamedJoint> joints;
  std::vector<NamedActuator> actuators;
  std::vector<NamedGroup> groups;
  std::vector<ControllerCase> controllers;
  LoadAveraging load_averaging = LoadAveraging::two_step;
  std::optional<double> virtual_mass;  ///< in displaced masses; 0: none, absent: by the rule of checks/light_bodies.cpp
  LubricationCase lubrication;
  std::optional<ContactCase> contact;  ///< absent: a run in which bodies meet ends
  std::int64_t steps = 0;
  std::optional<Periodicity> until_periodic;  ///< absent: the run takes all its steps
  OutputCase output;
  ServicesCase services;
};

/// Step of a lattice with the given relaxation time [s].
///   Δt = c_s² (τ − 1/2) Δx² / ν,   c_s² = 1/3        [docs/theory.md]
double step_from_relaxation_time(double relaxation_time, double cell_size_m, double viscosity_m2_per_s);
/// The given one, or that which follows from the relaxation time; 0: neither can be used.
double step_of(const FluidCase& fluid, std::optional<double> given_step_s);
/// Its inverse: τ = 1/2 + ν Δt / (c_s² Δx²).
double relaxation_time_from_step(double step_s, double cell_size_m, double viscosity_m2_per_s);

/// Key path of what a swimmer was read from.
inline std::string path_of_swimmer(const Case& the_case, std::size_t number) {
  return the_case.swimmers[number].is_of_swarm ? "swarm.template" : "swimmers." + std::to_string(number);
}

/// That of a case.
double relaxation_time(const Case& the_case);

/// Drag of a sphere in Stokes flow by its speed, 6πμr [kg/s].
double stokes_drag_kg_per_s(double radius_m, const FluidSetup& fluid);

inline bool on_lattice(const Case& the_case) { return the_case.fluid.solver == FluidSolverChoice::lattice_boltzmann; }

/// Cells that are computed: the whole domain, halved for every symmetry plane; 0 without a lattice.
std::int64_t computed_cells(const FluidCase& fluid);
/// 19 populations per computed cell [bytes].
std::int64_t population_bytes(const FluidCase& fluid);

// The words of the case file for the coupler's own enumerators; those of the contract are in
// contract/words.hpp.

inline constexpr auto solver_names = words<FluidSolverChoice>("lattice_boltzmann", "stokes", "vacuum", "external");
inline constexpr auto body_solver_names = words<BodySolverChoice>("own", "bullet", "mujoco", "external");
inline constexpr auto orientation_names = words<BeadOrientation>("parallel", "perpendicular");
inline constexpr auto averaging_names = words<LoadAveraging>("none", "two_step");

enum class SchemeKind { serial_explicit };
inline constexpr auto scheme_names = words<SchemeKind>("serial_explicit");
inline constexpr auto trajectory_format_names = words<TrajectoryFormat>("auto", "csv", "npy");

inline constexpr std::array axis_names{"x", "y", "z"};

/// Key path of a face by its number in the order of FluidSetup::boundaries.
inline std::string face_path(std::size_t face) {
  return std::string("fluid.boundaries.") + axis_names[face / 2] + (face % 2 == 0 ? ".low" : ".high");
}

}  // namespace copepod::coupler
