#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {
namespace {

/// Lattice velocity above which compressibility shows.
constexpr double fast_lu = 0.1;

void judge_velocity(double velocity_m_per_s, const Case& the_case, const std::string& path, const std::string& what,
                    Problems& problems) {
  const double velocity_lu = velocity_m_per_s * the_case.step_s / the_case.fluid.cell_size_m;
  const std::string found = what + " is " + rounded_text(velocity_lu) + " cells per step";
  if (velocity_lu > largest_speed_lu) {
    problems.error(path, found +
                             " (the lattice is unstable above about 0.4; the speed of sound is 0.577). Use a smaller "
                             "step or slower motion.");
  } else if (velocity_lu > fast_lu) {
    problems.warning(path, found + " (compressibility shows above about 0.1). Use a smaller step or slower motion.");
  }
}

/// Pressure is density on a lattice: ρ/ρ₀ = 1 + 3 p Δt² / (ρ₀ Δx²). It may do to the density what a flow does
/// that is stopped from the velocities above, 3 u²/2.
void judge_pressure(double pressure_Pa, const Case& the_case, const std::string& path, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  const double seconds_per_m = the_case.step_s / fluid.cell_size_m;
  const double excess = 3.0 * pressure_Pa * seconds_per_m * seconds_per_m / fluid.density_kg_per_m3;
  const std::string found =
      "the pressure of " + path + " makes the density there " + rounded_text(1.0 + excess) + " times the fluid's";
  const std::string remedy = "Use a smaller step, or pressures nearer to 0 (only their differences drive the flow).";
  if (std::abs(excess) > 1.5 * largest_speed_lu * largest_speed_lu) {
    problems.error(path, found + " (unlike a liquid, the lattice fluid is compressible, and it fails at 0). " + remedy);
  } else if (std::abs(excess) > 1.5 * fast_lu * fast_lu) {
    problems.warning(path, found + " (volume fluxes will differ by as much between faces). " + remedy);
  }
}

/// Stiffness that a force between two bodies works against: of all springs between them [N/m].
using StiffnessBetween = std::map<std::pair<int, int>, double>;

/// Amplitude of a body's velocity under a force that varies with angular frequency ω, the smallest of what drag,
/// inertia and the springs along the force alone allow [m/s]:
///   a / (6π ρ ν r),  a / (ω m)  and  ω a / k
double expected_velocity_m_per_s(const BodySpecification& body, double force_N, double frequency_rad_per_s,
                                 double stiffness_N_per_m, const FluidCase& fluid) {
  const double by_drag = force_N / stokes_drag_kg_per_s(body.shape.radius_m, fluid);
  const double free = std::min(by_drag, force_N / (frequency_rad_per_s * body.mass_kg));
  return stiffness_N_per_m > 0.0 ? std::min(free, frequency_rad_per_s * force_N / stiffness_N_per_m) : free;
}

/// Judges the speed that drive number `index`, a pair force with a period, gives its bodies, and how far they move.
void judge_pair_force(std::size_t index, const StiffnessBetween& stiffness_between, const Case& the_case,
                      const Assembly& assembly, Problems& problems) {
  const DrivenActuator& driven = assembly.drive[index];
  const std::string& path = assembly.signal_paths[index];
  const BodySpecification& A = assembly.bodies[driven.actuator.body_A];
  const BodySpecification& B = assembly.bodies[driven.actuator.body_B];
  const std::string pair = "'" + A.name + "' and '" + B.name + "'";
  const double force_N = largest_magnitude(driven.signal);
  const double frequency_rad_per_s =
      2.0 * std::numbers::pi / (static_cast<double>(driven.signal.period_steps) * the_case.step_s);
  const auto springs = stiffness_between.find(std::minmax(driven.actuator.body_A, driven.actuator.body_B));
  const double stiffness_N_per_m = springs == stiffness_between.end() ? 0.0 : springs->second;
  const auto velocity_of = [&](const BodySpecification& body) {
    return expected_velocity_m_per_s(body, force_N, frequency_rad_per_s, stiffness_N_per_m, the_case.fluid);
  };
  const double velocity_m_per_s = std::max(velocity_of(A), velocity_of(B));
  judge_velocity(velocity_m_per_s, the_case, path, "the expected speed of " + pair, problems);
  const double reach_m = velocity_m_per_s / frequency_rad_per_s;
  const bool rest_length = assembly.drive_springs[index] >= 0;  // judged by its amplitude
  if (!rest_length && reach_m > surface_distance_m(A, B)) {
    problems.warning(
        path,
        pair + " may move by " + length_text(reach_m) +
            ", more than the gap between them (they could collide). Use a smaller amplitude or a shorter period.");
  }
}

/// A rest length that varies by the gap between its bodies.
void judge_rest_length(std::size_t index, const Assembly& assembly, Problems& problems) {
  const SpringSpecification& spring = assembly.springs[assembly.drive_springs[index]];
  if (std::min(spring.body_A, spring.body_B) < 0) return;  // reported by check_names
  const BodySpecification& A = assembly.bodies[spring.body_A];
  const BodySpecification& B = assembly.bodies[spring.body_B];
  const double gap_m = surface_distance_m(A, B);
  const double shortening_m = -range_of(assembly.drive[index].signal).first / spring.stiffness_N_per_m;
  if (!(shortening_m >= gap_m)) return;
  problems.warning(assembly.signal_paths[index] + ".amplitude_m",
                   "the rest length between '" + A.name + "' and '" + B.name + "' shortens by " +
                       length_text(shortening_m) + ", the gap between them is " + length_text(gap_m) +
                       " (they could collide). Use a smaller amplitude_m.");
}

/// Bounce-back, whose loads are not the same in every frame, leaves out ρ V Ω × U: in parts of Stokes' drag, 6π ρ ν r
/// U, 2/9 r² Ω/ν of a sphere whose velocities are perpendicular.
void judge_turning(const BodySpecification& body, double factor, const Case& the_case, const std::string& path,
                   Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  const double speed_m_per_s = body.velocity_m_per_s.norm();
  if (fluid.moving_boundary != MovingBoundary::bounce_back || !(factor * speed_m_per_s > 0.0)) return;
  const double share = factor * body.angular_velocity_rad_per_s.cross(body.velocity_m_per_s).norm() / speed_m_per_s *
                       volume_m3(body.shape) /
                       (6.0 * std::numbers::pi * fluid.kinematic_viscosity_m2_per_s * body.shape.radius_m);
  if (share < 0.05) return;
  problems.warning(path,
                   "body '" + body.name + "' moves and turns (moving_boundary: bounce_back leaves out the force " +
                       "ρ V Ω × U, here " + rounded_text(share) + " times its drag). Use moving_boundary: parabolic.");
}

/// Mach number.
void check_velocities(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (!on_lattice(the_case) || !(the_case.step_s > 0.0)) return;
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    const BodySpecification& body = assembly.bodies[i];
    const double surface_speed = body.velocity_m_per_s.norm() + body.angular_velocity_rad_per_s.norm() *
                                                                    (body.shape.radius_m + 0.5 * body.shape.length_m);
    const auto moved = std::ranges::find(assembly.prescribed, static_cast<int>(i), &PrescribedBody::body);
    const bool varies = moved != assembly.prescribed.end();
    const double factor = varies ? largest_magnitude(moved->signal) : 1.0;
    const std::string path = assembly.body_paths[i] + (varies ? ".motion" : ".velocity_m_per_s");
    judge_velocity(surface_speed * factor, the_case, path,
                   (varies ? "the largest speed of body '" : "the initial speed of body '") + body.name + "'",
                   problems);
    judge_turning(body, factor, the_case, path, problems);
  }
  const InitialFlow& flow = the_case.fluid.initial_flow;
  const double slenderness = static_cast<double>(the_case.fluid.domain_cells[1]) /
                             static_cast<double>(the_case.fluid.domain_cells[0]);  // of a Taylor-Green vortex
  judge_velocity(std::max(flow.velocity_m_per_s.norm(), flow.speed_m_per_s * std::max(1.0, slenderness)), the_case,
                 "fluid.initial_flow", "the speed of the initial flow", problems);
  for (std::size_t face = 0; face < 6; ++face) {
    const Boundary& boundary = the_case.fluid.boundaries[face];
    judge_velocity(boundary.largest_speed(), the_case, face_path(face), "the speed of the wall", problems);
    judge_pressure(boundary.pressure_Pa, the_case, face_path(face), problems);
  }
  StiffnessBetween stiffness_between;
  for (const SpringSpecification& spring : assembly.springs)
    stiffness_between[std::minmax(spring.body_A, spring.body_B)] += spring.stiffness_N_per_m;
  for (std::size_t i = 0; i < assembly.drive.size(); ++i) {
    const DrivenActuator& driven = assembly.drive[i];
    const bool judged = i > 0 && assembly.signal_paths[i] == assembly.signal_paths[i - 1];  // arms of one stroke
    if (driven.actuator.kind != ActuatorKind::pair_force || driven.signal.period_steps == 0 || judged) continue;
    judge_pair_force(i, stiffness_between, the_case, assembly, problems);
  }
}

/// Waves that are sampled too coarsely or of which no cycle is run, rest lengths that vary too much.
void check_signals(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const auto judge_period = [&problems](const Signal& signal, const std::string& signal_path) {
    if (signal.period_steps == 0 || signal.period_steps >= 20) return;
    const std::string path = signal_path + ".period_steps";
    problems.reject(path, "is " + std::to_string(signal.period_steps) +
                              " (a wave needs at least 20 steps). Use a longer period or a smaller step.");
  };
  for (const auto& [body, signal] : assembly.prescribed)
    judge_period(signal, assembly.body_paths[body] + ".motion.prescribed.signal");
  for (std::size_t face = 0; face < 6; ++face)
    if (const auto& signal = the_case.fluid.boundaries[face].signal) judge_period(*signal, face_path(face) + ".signal");
  bool cycle_is_run = true;
  for (std::size_t i = 0; i < assembly.drive.size(); ++i) {
    const Signal& signal = assembly.drive[i].signal;
    const std::string& signal_path = assembly.signal_paths[i];
    if (assembly.drive_springs[i] >= 0) judge_rest_length(i, assembly, problems);
    const bool judged = i > 0 && signal_path == assembly.signal_paths[i - 1];
    if (signal.period_steps == 0 || judged) continue;
    judge_period(signal, signal_path);
    const bool stroke = signal_path.ends_with(".stroke");  // judged by check_strokes
    if (!cycle_is_run || stroke || signal.period_steps <= the_case.steps) continue;
    cycle_is_run = false;  // one warning is enough
    problems.warn("run.steps", "is " + std::to_string(the_case.steps) + ", the period of " + signal_path + " " +
                                   std::to_string(signal.period_steps) +
                                   " (no whole cycle is measured). Run longer, or use a shorter period.");
  }
}

void check_strokes(const Case& the_case, Problems& problems) {
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    if (!the_case.swimmers[i].three_beads) continue;
    const Stroke& stroke = the_case.swimmers[i].three_beads->stroke;
    const std::string path = path_of_swimmer(the_case, i) + ".stroke";
    if (stroke.phase_lag_steps >= stroke.period_steps) {
      problems.reject(path + ".phase_lag_steps",
                      "is " + std::to_string(stroke.phase_lag_steps) + ", the period " +
                          std::to_string(stroke.period_steps) +
                          " (a lag of a whole period or more means something else). Use a lag within one period.");
    }
    if (stroke.cycles * stroke.period_steps > the_case.steps) {
      problems.warn("run.steps", "is " + std::to_string(the_case.steps) + ", the stroke of '" +
                                     the_case.swimmers[i].name + "' needs " +
                                     std::to_string(stroke.cycles * stroke.period_steps) +
                                     " (the analysis uses its last period). Run longer for a result table.");
    } else if (the_case.until_periodic && stroke.cycles * stroke.period_steps < the_case.steps) {
      problems.warn(path + ".cycles", "is " + std::to_string(stroke.cycles) +
                                          " (the stroke ends before the run, which run.until_periodic can then no "
                                          "longer end). Give it as many cycles as the run.");
    }
  }
}

void check_coefficients(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const std::int64_t every_steps = the_case.output.trajectory_every_steps;
  const std::int64_t last = every_steps > 0 ? (the_case.steps - 1) / every_steps * every_steps : 0;
  std::set<std::string> known, seen;
  for (const BodySpecification& body : assembly.bodies) known.insert(body.name);
  for (const ObstacleSpecification& obstacle : the_case.fluid.obstacles)
    if (obstacle.loads) known.insert(obstacle.name);
  for (std::size_t i = 0; i < the_case.output.coefficients.size(); ++i) {
    const Coefficients& each = the_case.output.coefficients[i];
    const auto reject_if = [&](bool is_wrong, const char* key, const std::string& problem) {
      if (is_wrong) problems.reject("output.coefficients." + std::to_string(i) + key, problem);
    };
    reject_if(the_case.fluid.density_kg_per_m3 == 0.0, "",
              "needs the fluid's density (it is a force by ρ U² A/2). Give fluid.density_kg_per_m3.");
    reject_if(!known.contains(each.of), ".of",
              "is '" + each.of + "' (neither a body nor an obstacle with loads). Give the obstacle loads: true.");
    reject_if(!seen.insert(each.of).second, ".of", "is '" + each.of + "' again (names of columns). Remove one.");
    reject_if(std::abs(each.drag_axis.dot(each.lift_axis)) > 1e-3, ".lift_axis",
              "is not perpendicular to drag_axis (the lift would hold drag). Give a direction across it.");
    reject_if(each.from_step > last || last == 0, ".from_step",
              "is " + std::to_string(each.from_step) +
                  ", the last sample of the trajectory before the end that of step " + std::to_string(last) +
                  " (nothing is left to evaluate). Start earlier, or sample more often.");
  }
}

void check_output(const Case& the_case, Problems& problems) {
  const OutputCase& output = the_case.output;
  const std::int64_t start = output.fields.mean_start, stop = output.fields.mean_stop;
  const std::string path = "output.fields.mean_over_steps";
  const std::vector<std::int64_t>& region = output.fields.region_cells;
  for (std::size_t axis = 0; axis < 3 && !region.empty(); ++axis) {
    const std::int64_t cells = the_case.fluid.domain_cells[axis];
    if (cells == 0 || region[2 * axis + 1] <= cells) continue;
    const std::string key = std::string("output.fields.region_cells.") + axis_names[axis];
    problems.reject(key, "ends behind cell " + std::to_string(region[2 * axis + 1] - 1) + " (the domain has " +
                             std::to_string(cells) + ", the first is 0). Use cells of the domain.");
  }
  for (std::size_t i = 0; i < output.flow.probes.size(); ++i) {
    const auto& [name, at_m] = output.flow.probes[i];
    const std::string key = "output.flow.probes." + std::to_string(i);
    const Eigen::Vector3d length_m = the_case.fluid.length_m();
    if (!length_m.isZero(0.0) && !((at_m.array() >= 0.0).all() && (at_m.array() <= length_m.array()).all()))
      problems.reject(key + ".position_m", "is outside the domain (nothing flows there). Move it inside.");
    if (&*std::ranges::find(output.flow.probes, name, &Probe::name) != &output.flow.probes[i])
      problems.reject(key + ".name", "names two probes (columns have different names). Rename one.");
    if (!output.flow.faces.empty() && std::ranges::count(face_names, name) > 0)
      problems.reject(key + ".name", "is that of a face (columns have different names). Rename the probe.");
  }
  const bool has_places = !output.flow.probes.empty() || !output.flow.faces.empty();
  if (output.flow.every_steps > 0 && !output.flow.totals && !has_places)
    problems.reject("output.flow",
                    "samples nothing (totals: false, no probes, and no faces). Add probes or faces, or remove it.");
  if (output.flow.every_steps == 0 && has_places)
    problems.reject("output.flow.every_steps",
                    "is 0 (probes and faces would never be sampled). Give a number of steps.");
  if (output.flow.every_steps > 0 && output.flow_from_step > the_case.steps)
    problems.reject("output.flow.from_step", "is after the last step (nothing is left to evaluate). Start earlier.");
  else if (output.flow.every_steps > 0 &&
           output.flow_from_step > (the_case.steps - 1) / output.flow.every_steps * output.flow.every_steps)
    problems.warn("output.flow.from_step",
                  "is after the last sample (summary.json will have no means). Start earlier, or sample more often.");
  if (stop == 0 && start == 0) return;
  if (stop <= start) {
    problems.reject(path, "stops at " + std::to_string(stop) + " before it starts at " + std::to_string(start) +
                              " (the mean would be empty). Write [start, stop] with start < stop.");
  } else if (stop > the_case.steps) {
    problems.reject(path, "stops at " + std::to_string(stop) + ", the run after " + std::to_string(the_case.steps) +
                              " steps (the mean would never be written). Run longer or stop earlier.");
  } else if (the_case.until_periodic) {
    problems.warn(path, "stops at " + std::to_string(stop) +
                            " (the run ends earlier if run.until_periodic is reached, and writes no mean then). Give "
                            "only one of them.");
  } else if (output.fields.mean_every_steps > stop - start) {
    problems.warn("output.fields.mean_every_steps",
                  "takes one sample in the whole window (no mean). Use a smaller number.");
  }
}

/// What can run in one process.
void check_services(const Case& the_case, Problems& problems) {
  const ServicesCase& services = the_case.services;
  if (services.transport != in_process_transport) return;
  if (!services.fluid_command.empty() || !services.body_command.empty() ||
      the_case.fluid.solver == FluidSolverChoice::external || the_case.body.solver != BodySolverChoice::own) {
    problems.reject("services.transport",
                    "is in_process (other components than our own must be processes). Write transport: ipc.");
  }
  if (!the_case.controllers.empty()) {
    problems.reject("services.transport",
                    "is in_process (controllers are processes of their own). Write transport: ipc, or steer a "
                    "copepod.Simulation of the case without controllers.");
  }
  if (the_case.output.wire) {
    problems.reject("output.wire",
                    "is true (services.transport is in_process: there are no messages to record). Write transport: "
                    "ipc, or wire: false.");
  }
}

}  // namespace

void check_case(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const bool time = !problems.any_under("fluid") && !problems.any_under("step_s");
  const bool domain = time && !problems.any_under("services");
  const bool bodies = !problems.any_under("swimmers") && !problems.any_under("bodies");
  const bool springs =
      bodies && !problems.any_under("springs") && !problems.any_under("bends") && !problems.any_under("actuators");
  const bool run = !problems.any_under("run");
  if (time) check_time(the_case, problems);
  if (domain) check_domain(the_case, problems);
  if (domain && bodies) check_solvers(the_case, assembly, problems);
  if (bodies) check_names(the_case, assembly, problems);
  if (time && springs) check_symmetry(the_case, assembly, problems);
  if (time && bodies) check_bodies(the_case, assembly, problems);
  if (springs) check_springs(the_case, assembly, problems);
  if (bodies && !problems.any_under("joints")) check_joints(the_case, assembly, problems);
  if (springs && run) check_signals(the_case, assembly, problems);
  if (springs && run) check_strokes(the_case, problems);
  if (time && springs && !problems.any()) check_velocities(the_case, assembly, problems);
  if (time && bodies && !problems.any()) check_light_bodies(the_case, assembly, problems);
  if (time && springs && !problems.any()) check_stiffness(the_case, assembly, problems);
  if (time && bodies && !problems.any()) check_schemes(the_case, assembly, problems);
  if (time && springs && !problems.any()) check_mixture(the_case, assembly, problems);
  if (time && springs && !problems.any()) check_contact(the_case, assembly, problems);
  if (run && !problems.any_under("output")) check_output(the_case, problems);
  if (run && bodies && !problems.any_under("output") && !problems.any_under("body.model"))
    check_coefficients(the_case, assembly, problems);
  if (domain) check_services(the_case, problems);
}

}  // namespace copepod::coupler
