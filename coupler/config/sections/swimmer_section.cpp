#include <cmath>
#include <initializer_list>

#include "config/sections/names.hpp"
#include "config/sections/sections.hpp"

namespace copepod::coupler {
namespace {

Bead read_bead(Reader bead) {
  Bead result;
  result.shape = read_shape(bead);
  const bool capsule = result.shape.kind == ShapeKind::capsule;
  result.orientation = bead.choice("orientation", orientation_names,
                                   capsule ? std::nullopt : std::optional(BeadOrientation::parallel));
  return result;
}

Stroke read_stroke(Reader stroke) {
  Stroke result;
  result.amplitude_N = stroke.number("amplitude_N", Range::any);
  result.period_steps = stroke.integer("period_steps", Range::positive);
  result.phase_lag_steps = stroke.integer("phase_lag_steps", Range::not_negative);
  result.cycles = stroke.integer("cycles", Range::positive);
  constexpr std::int64_t most_steps = 1'000'000'000'000;
  if (result.period_steps > 0 && result.cycles > most_steps / result.period_steps) {
    stroke.problems().error(stroke.path_of("cycles"),
                            stroke.path_of("cycles") + " is " + std::to_string(result.cycles) +
                                " (more steps than can be counted). Use fewer cycles.");
    result.cycles = 1;
  }
  return result;
}

/// γ as given, or from the damping ratio D = γ / (2 √(m k))   [paper, eq. (11)]
double read_damping(Reader& spring, double stiffness_N_per_m, double mass_kg) {
  const double given = spring.number("damping_N_s_per_m", Range::not_negative, 0.0);
  if (!spring.has("damping_ratio")) return given;
  const double ratio = spring.number("damping_ratio", Range::not_negative, 0.0);
  if (spring.has("damping_N_s_per_m")) {
    spring.problems().error(
        spring.path_of("damping_ratio"),
        spring.path_of("damping_ratio") +
            " is given beside damping_N_s_per_m (one follows from the other). Remove one.");
  }
  return 2.0 * ratio * std::sqrt(mass_kg * stiffness_N_per_m);
}

void read_figures(Reader& section, std::initializer_list<const char*> keys, const std::string& prefix,
                  PublishedFigures& figures) {
  for (const char* key : keys) {
    if (section.has(key)) figures.emplace_back(prefix + key, section.number(key, Range::any));
  }
}

PublishedFigures read_published(Reader published) {
  PublishedFigures figures;
  read_figures(published,
               {"u_swim_lattice", "d1_cells", "d2_cells", "sin_dphi", "K", "u_GA_lattice", "error_percent",
                "efficiency", "Re_swim"},
               "", figures);
  Reader bodies = published.section("Re_bodies");
  read_figures(bodies, {"B2", "B1", "B3"}, "Re_bodies.", figures);
  return figures;
}

}  // namespace

Swimmer read_swimmer(Reader swimmer) {
  Swimmer result;
  result.name = swimmer.text("name");
  result.center_m = swimmer.numbers("center_m", 3);
  result.axis = read_direction(swimmer, "axis", Eigen::Vector3d::UnitZ());
  const std::size_t beads = swimmer.size("beads");
  if (beads == 3) {
    for (std::size_t i = 0; i < 3; ++i) result.beads[i] = read_bead(swimmer.item("beads", i));
  } else {
    swimmer.problems().error(swimmer.path_of("beads"),
                             swimmer.path_of("beads") + " has " + std::to_string(beads) +
                                 " entries (a swimmer has three). List trailing, middle and leading bead.");
  }
  result.bead_mass_kg = swimmer.number("bead_mass_kg", Range::positive);
  const Eigen::Vector2d gaps = swimmer.numbers("rest_gap_m", 2);
  result.rest_gap_m = {gaps[0], gaps[1]};
  {
    Reader spring = swimmer.section("spring");
    result.stiffness_N_per_m = spring.number("stiffness_N_per_m", Range::positive);
    result.damping_N_s_per_m = read_damping(spring, result.stiffness_N_per_m, result.bead_mass_kg);
  }
  result.stroke = read_stroke(swimmer.section("stroke"));
  result.published = read_published(swimmer.section("published"));
  return result;
}

}  // namespace copepod::coupler
