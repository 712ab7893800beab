#include <algorithm>
#include <cmath>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "config/sections/case.hpp"
#include "contract/number_text.hpp"

namespace copepod::coupler {
namespace {

bool is_loose(const BodySpecification& body) {
  return body.motion == MotionKind::free || body.motion == MotionKind::axis;
}

/// Steady forces on fluid and bodies together where no wall, open face, joint or held body takes them up [N].
Eigen::Vector3d net_force_N(const Case& the_case, const Assembly& assembly) {
  const FluidCase& fluid = the_case.fluid;
  double fluid_m3 = std::pow(fluid.cell_size_m, 3);
  for (const std::int64_t cells : fluid.domain_cells) fluid_m3 *= static_cast<double>(cells);
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  for (const BodySpecification& body : assembly.bodies) {
    if (!is_loose(body)) return Eigen::Vector3d::Zero();
    const double displaced_m3 = volume_m3(body.shape);
    force_N += (body.mass_kg - fluid.density_kg_per_m3 * displaced_m3) * the_case.body.gravity_m_per_s2;
    fluid_m3 -= displaced_m3;
  }
  force_N += fluid_m3 * fluid.body_force_N_per_m3;
  for (const auto& [actuator, signal] : assembly.drive)
    if (actuator.kind == ActuatorKind::world_force && signal.kind == SignalKind::constant)
      force_N += signal.amplitude * actuator.direction;
  for (std::size_t face = 0; face < 6; ++face) {
    const BoundaryKind kind = fluid.boundaries[face].kind;
    if (kind == BoundaryKind::free_slip)
      force_N[static_cast<Eigen::Index>(face / 2)] = 0.0;
    else if (kind != BoundaryKind::periodic)
      return Eigen::Vector3d::Zero();
  }
  const auto to_the_world = [](const auto& link) { return std::min(link.body_A, link.body_B) < 0; };
  const bool held =
      std::ranges::any_of(assembly.joints, to_the_world) || std::ranges::any_of(assembly.springs, to_the_world);
  return held ? Eigen::Vector3d::Zero() : force_N;
}

}  // namespace

void check_mixture(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  if (fluid.solver != FluidSolverChoice::lattice_boltzmann || assembly.bodies.empty()) return;
  const auto loose = std::ranges::find_if(assembly.bodies, is_loose);
  if (!fluid.body_force_N_per_m3.isZero(0.0) && loose != assembly.bodies.end()) {
    problems.warning("fluid.body_force_N_per_m3",
                     "fluid.body_force_N_per_m3 acts on the fluid alone (body '" + loose->name + "' lacks " +
                         rounded_text(fluid.body_force_N_per_m3.norm() * volume_m3(loose->shape)) +
                         " N of what a pressure gradient would exert: a neutral sphere of 0.6 of a slit's width moves "
                         "9 % slower). Use pressure_Pa at the faces, or give bodies a world_force.");
  }
  const Eigen::Vector3d force_N = net_force_N(the_case, assembly);
  double mass_kg = fluid.density_kg_per_m3 * std::pow(fluid.cell_size_m, 3);
  for (const std::int64_t cells : fluid.domain_cells) mass_kg *= static_cast<double>(cells);
  const double gain_lu = force_N.norm() / mass_kg * static_cast<double>(the_case.steps) * the_case.step_s *
                         the_case.step_s / fluid.cell_size_m;
  if (gain_lu < 1e-6) return;
  problems.warning("fluid.boundaries",
                   "a net force of " + rounded_text(force_N.norm()) +
                       " N acts on fluid and bodies (nothing holds them: they accelerate for ever, by " +
                       rounded_text(gain_lu) +
                       " cells per step until the end of the run). Balance it by fluid.body_force_N_per_m3, or add a "
                       "wall or a fixed body.");
}

}  // namespace copepod::coupler
