#include <cmath>
#include <initializer_list>

#include "config/sections/sections.hpp"

namespace copepod::coupler {
namespace {

Bead read_bead(Reader bead) {
  Bead result;
  result.shape = read_shape(bead);
  const bool capsule = result.shape.kind == ShapeKind::capsule;
  result.orientation =
      bead.choice("orientation", orientation_names, capsule ? std::nullopt : std::optional(BeadOrientation::parallel));
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
    stroke.problems().error(stroke.path_of("cycles"), stroke.path_of("cycles") + " is " +
                                                          std::to_string(result.cycles) +
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
    spring.problems().error(spring.path_of("damping_ratio"),
                            spring.path_of("damping_ratio") +
                                " is given together with damping_N_s_per_m (one follows from the other). Remove one.");
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

Value resolved_published(const PublishedFigures& figures) {
  const std::string of_bodies = "Re_bodies.";
  Value section = Value::mapping();
  Value bodies = Value::mapping();
  for (const auto& [key, value] : figures) {
    if (key.starts_with(of_bodies))
      bodies.add(key.substr(of_bodies.size()), Value::of_number(value));
    else
      section.add(key, Value::of_number(value));
  }
  if (!bodies.entries.empty()) section.add("Re_bodies", std::move(bodies));
  return section;
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

Value resolved_swimmer(const Swimmer& swimmer) {
  Value section = Value::mapping();
  section.add("name", Value::of_text(swimmer.name));
  section.add("center_m", Value::of_vector(swimmer.center_m));
  section.add("axis", Value::of_vector(swimmer.axis));
  Value beads = Value::sequence();
  for (const Bead& bead : swimmer.beads) {
    Value item = Value::mapping();
    add_shape(item, bead.shape);
    beads.add(std::move(item.add("orientation", word(orientation_names, bead.orientation))));
  }
  section.add("beads", std::move(beads));
  section.add("bead_mass_kg", Value::of_number(swimmer.bead_mass_kg));
  section.add("rest_gap_m", Value::of_vector(Eigen::Vector2d(swimmer.rest_gap_m[0], swimmer.rest_gap_m[1])));
  Value spring = Value::mapping();
  spring.add("stiffness_N_per_m", Value::of_number(swimmer.stiffness_N_per_m));
  spring.add("damping_N_s_per_m", Value::of_number(swimmer.damping_N_s_per_m));
  section.add("spring", std::move(spring));
  Value stroke = Value::mapping();
  stroke.add("amplitude_N", Value::of_number(swimmer.stroke.amplitude_N));
  stroke.add("period_steps", Value::of_integer(swimmer.stroke.period_steps));
  stroke.add("phase_lag_steps", Value::of_integer(swimmer.stroke.phase_lag_steps));
  stroke.add("cycles", Value::of_integer(swimmer.stroke.cycles));
  section.add("stroke", std::move(stroke));
  if (!swimmer.published.empty()) section.add("published", resolved_published(swimmer.published));
  return section;
}

}  // namespace copepod::coupler
