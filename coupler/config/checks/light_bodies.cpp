#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <spdlog/fmt/fmt.h>

#include "config/checks/checks.hpp"
#include "contract/words.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::coupler {
namespace {

/// Below it a load that alternates from step to step meets so little damping that averaging is the cheaper remedy;
/// above it the half step by which averaging delays the drag does more harm.
constexpr double averaged_below = 0.75;

/// D, the part of the displaced fluid's angular momentum that the drag of one step takes: 15 ν/r². Above this one a
/// rotation without mass is unstable with any virtual mass.
double drag_of_a_step(double radius_cells, double relaxation_time) {
  return 5.0 * (relaxation_time - 0.5) / (radius_cells * radius_cells);
}
constexpr double largest_drag_of_a_step = 0.65;

/// Stress follows motion τ steps late: what rotates needs a mass of 0.3 (τ D − 1), or up to this τ D four times the
/// virtual mass.
constexpr double latest_drag = 1.6;
double least_turning_mass(double late_drag) { return 0.3 * (late_drag - 1.0); }

/// (−1)^(x+t) j_x, which collisions conserve: what these surfaces send back of it lets a light body oscillate.
bool returns_staggered_momentum(MovingBoundary boundary) {
  return boundary == MovingBoundary::bounce_back || boundary == MovingBoundary::central_linear;
}

/// Of the sphere whose load answers a step in velocity as strongly, per displaced mass: 5/3r times the step. The links
/// through a surface answer with ∫ A (V + Ω × x) dS, A = 1/3 + 2/3 n nᵀ per cell; the most of all V and Ω counts.
double response_radius_m(const Shape& shape) {
  if (is_round(shape)) return shape.radius_m;
  const Surface surface = make_solid(shape)->surface(32);
  Eigen::Matrix3d pushed = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d turned = Eigen::Matrix3d::Zero();
  surface.for_each_triangle([&](int a, int b, int c) {
    const Eigen::Vector3d first = surface.points.col(a);
    const Eigen::Vector3d to_second = surface.points.col(b) - first;
    const Eigen::Vector3d to_third = surface.points.col(c) - first;
    const Eigen::Vector3d area = 0.5 * to_second.cross(to_third);
    if (area.isZero(0.0)) return;
    const Eigen::Matrix3d A =
        area.norm() / 3.0 * Eigen::Matrix3d::Identity() + 2.0 / 3.0 * area * area.transpose() / area.norm();
    const Eigen::Vector3d x = first + (to_second + to_third) / 3.0;
    const Eigen::Matrix3d velocity{{0, x[2], -x[1]}, {-x[2], 0, x[0]}, {x[1], -x[0], 0}};  // of Ω × x
    pushed += A;
    turned += velocity.transpose() * A * velocity;
  });
  using Most = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d>;
  const double volume = volume_m3(shape);
  const Eigen::Matrix3d displaced = volume * Eigen::Matrix3d::Identity();
  return 5.0 / 3.0 /
         std::max(Most(pushed, displaced).eigenvalues()[2],
                  Most(turned, inertia_tensor_kg_m2(shape, volume)).eigenvalues()[2]);
}

/// A body of a model has its mass from there, and no virtual one.
bool has_model(const Case& the_case) { return !the_case.body.model.text.empty(); }

/// Time in which a sphere in Stokes flow loses its momentum [s].
double damping_time_s(const BodySpecification& body, const FluidCase& fluid) {
  return body.mass_kg / stokes_drag_kg_per_s(body.shape.radius_m, fluid);
}

/// In Stokes flow, in displaced masses: up to M + m = 10/3 of the drag of a step, 6πμr Δt, with which a uniform sphere
/// loses all of its spin in a step, 8πμr³ Δt = 2/5 (M + m) r², and 3/10 of its velocity.
double overdamped_mass(const BodySpecification& body, const Case& the_case) {
  const double steps = damping_time_s(body, the_case.fluid) / the_case.step_s;
  return std::max(0.0, 10.0 / 3.0 / steps - 1.0) * mass_ratio(body, the_case.fluid);
}

/// The rule, fitted to the stability limits that follow from the measured response of a sphere's load to a step in its
/// velocity or angular velocity [docs/decisions/virtual_mass.md]:
///   needed below  max(1.4, 1.65 τ^(3/2)) / r   with averaged loads,   max(2.8/(τ − 1/2), 1.65 τ^(3/2)) / r   without
///   τ < 0.75, averaged loads:      m = min(1.5, 0.62 + 8.8 (τ − 1/2)) / r, with bgk 3.4 / r; parabolic
///                                  boundaries, whose loads do not alternate: the first of these, loads as they are
///   otherwise, loads as they are:  m = 1.2 / (r (τ − 1/2)) + 21 (τ − 1/2) / r²
/// @param radius_cells  r; of a capsule, too, whose load per displaced mass is smaller than that of the sphere
/// @param averaging     that of the case
VirtualMassRule virtual_mass_rule(double radius_cells, double relaxation_time, LoadAveraging averaging,
                                  const FluidCase& fluid) {
  const double excess = relaxation_time - 0.5;
  const bool averages = averaging == LoadAveraging::two_step;
  const double oscillating = averages ? 1.4 : 2.8 / excess;
  VirtualMassRule rule;
  rule.needed_below = std::max(oscillating, 1.65 * std::pow(relaxation_time, 1.5)) / radius_cells;
  const bool parabolic = fluid.moving_boundary == MovingBoundary::parabolic;
  if ((averages || parabolic) && relaxation_time < averaged_below) {
    if (!parabolic) rule.averaging = LoadAveraging::two_step;
    const bool late = fluid.collision == CollisionKind::bgk && !parabolic;
    rule.virtual_mass = (late ? 3.4 : std::min(1.5, 0.62 + 8.8 * excess)) / radius_cells;
  } else {
    rule.virtual_mass = 1.2 / (radius_cells * excess) + 21.0 * excess / (radius_cells * radius_cells);
  }
  return rule;
}

}  // namespace

double displaced_kg(const BodySpecification& body, const FluidCase& fluid) {
  return fluid.kind == FluidKind::vacuum ? 0.0 : fluid.density_kg_per_m3 * volume_m3(body.shape);
}

bool moves_under_loads(const BodySpecification& body) {
  return body.motion == MotionKind::free || body.motion == MotionKind::axis;
}

VirtualMassRule virtual_mass_rule(const BodySpecification& body, const Case& the_case) {
  const double radius_cells = response_radius_m(body.shape) / the_case.fluid.cell_size_m;
  const double tau = relaxation_time(the_case);
  VirtualMassRule rule = virtual_mass_rule(radius_cells, tau, the_case.load_averaging, the_case.fluid);
  const double late_drag = tau * drag_of_a_step(radius_cells, tau);
  if (late_drag <= latest_drag && mass_ratio(body, the_case.fluid) < least_turning_mass(late_drag))
    rule.virtual_mass *= 4.0;
  return rule;
}

double mass_ratio(const BodySpecification& body, const FluidCase& fluid) {
  const double ratio = body.mass_kg / displaced_kg(body, fluid);
  if (body.inertia_kg_m2.empty()) return ratio;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> turning(
      inertia_tensor_kg_m2(body), inertia_tensor_kg_m2(body.shape, displaced_kg(body, fluid)), Eigen::EigenvaluesOnly);
  return std::min(ratio, turning.eigenvalues()[0]);
}

VirtualMasses virtual_masses(const Case& the_case, const Assembly& assembly) {
  const auto displaced_masses = [&](const BodySpecification& body) {
    if (!moves_under_loads(body) || has_model(the_case)) return 0.0;
    if (the_case.virtual_mass) return *the_case.virtual_mass;
    if (the_case.fluid.kind == FluidKind::stokes) return overdamped_mass(body, the_case);
    if (!on_lattice(the_case)) return 0.0;
    const VirtualMassRule rule = virtual_mass_rule(body, the_case);
    return mass_ratio(body, the_case.fluid) < rule.needed_below ? rule.virtual_mass : 0.0;
  };
  VirtualMasses masses;
  for (const BodySpecification& body : assembly.bodies)
    masses.mass_kg.push_back(displaced_masses(body) * displaced_kg(body, the_case.fluid));
  masses.returns = the_case.virtual_mass || has_model(the_case) || the_case.fluid.kind != FluidKind::stokes;
  if (on_lattice(the_case)) {
    masses.averaging =
        virtual_mass_rule(1.0, relaxation_time(the_case), the_case.load_averaging, the_case.fluid).averaging;
  }
  return masses;
}

/// Without the implicit step of the drag: a uniform sphere that spins loses 8πμr³ Δt / (2/5 M r²) of its spin in a
/// step, which may be twice (M + 2 m)/M, as in the last equation of (C19) with z = −1.
void check_damping(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const VirtualMasses masses = virtual_masses(the_case, assembly);
  if (!masses.returns) return;
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    const BodySpecification& body = assembly.bodies[i];
    if (!moves_under_loads(body)) continue;
    const double longest_s =
        0.6 * damping_time_s(body, the_case.fluid) * (1.0 + 2.0 * masses.mass_kg[i] / body.mass_kg);
    if (the_case.step_s < longest_s) continue;
    return problems.error(
        "step_s",
        fmt::format("step_s is {} s (the drag on body '{}' makes it diverge above {} s). Use {}a smaller step.",
                    rounded_text(the_case.step_s), body.name, rounded_text(longest_s),
                    has_model(the_case) ? "" : "coupling.virtual_mass: auto, or "));
  }
}

void check_light_bodies(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (the_case.fluid.kind == FluidKind::stokes) check_damping(the_case, assembly, problems);
  if (!on_lattice(the_case)) return;
  const double tau = relaxation_time(the_case);
  const MovingBoundary boundary = the_case.fluid.moving_boundary;
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    const BodySpecification& body = assembly.bodies[i];
    const VirtualMassRule rule = virtual_mass_rule(body, the_case);
    const double ratio = mass_ratio(body, the_case.fluid);
    if (!moves_under_loads(body) || ratio >= rule.needed_below) continue;
    const std::string found =
        fmt::format("body '{}' has {:.3g} times the mass of the fluid that it displaces (", body.name, ratio);
    const double radius_cells = response_radius_m(body.shape) / the_case.fluid.cell_size_m;
    const double drag = drag_of_a_step(radius_cells, tau);
    const double given = has_model(the_case) ? 0.0 : the_case.virtual_mass.value_or(rule.virtual_mass);
    const bool averages = rule.averaging == LoadAveraging::two_step;
    if (drag > largest_drag_of_a_step || (tau * drag > latest_drag && ratio < least_turning_mass(tau * drag))) {
      problems.warning(
          assembly.body_paths[i],
          found + fmt::format("at a relaxation time of {:.3g} the drag of one step takes {:.2g} of the angular "
                              "momentum of as much fluid: its rotation may diverge). Use a smaller step.",
                              tau, drag));
    } else if (given < 0.6 * rule.virtual_mass) {
      problems.warning("coupling.virtual_mass",
                       found + fmt::format("the coupling may be unstable below {:.2g} with less than {:.2g} displaced "
                                           "masses as virtual mass). Use {}.",
                                           rule.needed_below, rule.virtual_mass,
                                           has_model(the_case) ? "heavier bodies, a model's have no virtual mass"
                                                               : "coupling.virtual_mass: auto"));
    } else if (tau < 0.6 && given > 1.4 * rule.virtual_mass) {
      problems.warning("coupling.virtual_mass",
                       found + fmt::format("at a relaxation time of {:.3g} sound may drive it with more than {:.2g} "
                                           "displaced masses as virtual mass). Use coupling.virtual_mass: auto.",
                                           tau, rule.virtual_mass));
    } else if (!averages && (returns_staggered_momentum(boundary) ||
                             (tau < averaged_below && boundary == MovingBoundary::interpolated))) {
      problems.warning("fluid.moving_boundary",
                       found +
                           "at some places between the cells it may oscillate from step to step). Use moving_boundary: "
                           "parabolic or, with load_averaging: two_step, a relaxation time below " +
                           fmt::format("{}.", averaged_below));
    }
  }
}

}  // namespace copepod::coupler
