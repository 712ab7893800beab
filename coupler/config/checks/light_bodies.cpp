#include "config/checks/light_bodies.hpp"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "config/checks/checks.hpp"

namespace copepod::coupler {
namespace {

/// Below it a load that alternates from step to step meets so little damping that averaging is the cheaper remedy;
/// above it the half step by which averaging delays the drag does more harm.
constexpr double averaged_below = 0.75;

/// Of the torque of drag in one step, 15 ν / r² of the displaced fluid's angular momentum: above it a body without
/// mass is unstable with any virtual mass.
constexpr double largest_drag_of_a_step = 0.65;

double relaxation_time(const Case& the_case) {
  return relaxation_time_from_step(the_case.step_s, the_case.fluid.cell_size_m,
                                   the_case.fluid.kinematic_viscosity_m2_per_s);
}

/// (−1)^(x+t) j_x, which collisions conserve: what these surfaces send back of it lets a light body oscillate.
bool returns_staggered_momentum(MovingBoundary boundary) {
  return boundary == MovingBoundary::bounce_back || boundary == MovingBoundary::central_linear;
}

bool moves_under_loads(const BodySpecification& body) {
  return body.motion == MotionKind::free || body.motion == MotionKind::axis;
}

double displaced_kg(const BodySpecification& body, const FluidCase& fluid) {
  return fluid.kind == FluidKind::vacuum ? 0.0 : fluid.density_kg_per_m3 * volume_m3(body.shape);
}

}  // namespace

VirtualMassRule virtual_mass_rule(double radius_cells, double relaxation_time, LoadAveraging averaging,
                                  MovingBoundary boundary) {
  const double excess = relaxation_time - 0.5;
  const bool averages = averaging == LoadAveraging::two_step;
  const double oscillating = averages ? 1.4 : 2.8 / excess;
  VirtualMassRule rule;
  rule.needed_below = std::max(oscillating, 1.65 * std::pow(relaxation_time, 1.5)) / radius_cells;
  if (averages && relaxation_time < averaged_below) {
    rule.virtual_mass = 1.5 / radius_cells;
    if (boundary != MovingBoundary::parabolic) rule.averaging = LoadAveraging::two_step;
  } else {
    rule.virtual_mass = 1.2 / (radius_cells * excess) + 21.0 * excess / (radius_cells * radius_cells);
  }
  return rule;
}

VirtualMassRule virtual_mass_rule(const BodySpecification& body, const Case& the_case) {
  return virtual_mass_rule(body.shape.radius_m / the_case.fluid.cell_size_m, relaxation_time(the_case),
                           the_case.load_averaging, the_case.fluid.moving_boundary);
}

double mass_ratio(const BodySpecification& body, const FluidCase& fluid) {
  return body.mass_kg / displaced_kg(body, fluid);
}

std::vector<double> virtual_masses_kg(const Case& the_case, const Assembly& assembly) {
  const auto displaced_masses = [&](const BodySpecification& body) {
    if (!moves_under_loads(body)) return 0.0;
    if (the_case.virtual_mass) return *the_case.virtual_mass;
    if (!on_lattice(the_case)) return 0.0;
    const VirtualMassRule rule = virtual_mass_rule(body, the_case);
    return mass_ratio(body, the_case.fluid) < rule.needed_below ? rule.virtual_mass : 0.0;
  };
  std::vector<double> masses_kg;
  masses_kg.reserve(assembly.bodies.size());
  for (const BodySpecification& body : assembly.bodies)
    masses_kg.push_back(displaced_masses(body) * displaced_kg(body, the_case.fluid));
  return masses_kg;
}

LoadAveraging averaging_with_virtual_mass(const Case& the_case) {
  if (!on_lattice(the_case)) return LoadAveraging::none;
  return virtual_mass_rule(1.0, relaxation_time(the_case), the_case.load_averaging, the_case.fluid.moving_boundary)
      .averaging;
}

void check_light_bodies(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (!on_lattice(the_case)) return;
  const double radius_per_cell = 1.0 / the_case.fluid.cell_size_m;
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    const BodySpecification& body = assembly.bodies[i];
    const VirtualMassRule rule = virtual_mass_rule(body, the_case);
    const double ratio = mass_ratio(body, the_case.fluid);
    if (!moves_under_loads(body) || ratio >= rule.needed_below) continue;
    const std::string found =
        fmt::format("body '{}' has {:.3g} times the mass of the fluid that it displaces (", body.name, ratio);
    const double radius_cells = body.shape.radius_m * radius_per_cell;
    const double drag_of_a_step = 5.0 * (relaxation_time(the_case) - 0.5) / (radius_cells * radius_cells);
    if (drag_of_a_step > largest_drag_of_a_step) {
      problems.warning(
          assembly.body_paths[i],
          found + fmt::format("the drag of one step takes {:.2g} of the angular momentum of as much fluid: "
                              "its rotation may diverge). Use a smaller step or smaller cells.",
                              drag_of_a_step));
    } else if (the_case.virtual_mass && *the_case.virtual_mass < 0.6 * rule.virtual_mass) {
      problems.warning("coupling.virtual_mass",
                       found + fmt::format("the coupling may be unstable below {:.2g} with less than {:.2g} displaced "
                                           "masses as virtual mass). Use coupling.virtual_mass: auto.",
                                           rule.needed_below, rule.virtual_mass));
    } else if (rule.averaging == LoadAveraging::none && returns_staggered_momentum(the_case.fluid.moving_boundary)) {
      problems.warning("fluid.moving_boundary",
                       found +
                           "at some places between the cells it may oscillate from step to step). Use "
                           "moving_boundary: parabolic or, with load_averaging: two_step, a relaxation time below " +
                           fmt::format("{}.", averaged_below));
    }
  }
}

}  // namespace copepod::coupler
