#include <initializer_list>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "geometry/rotation.hpp"

// What only the paper's swimmers have: the shorthand for three beads in a row, and published figures.

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// A bead of the shorthand: a capsule lies along the swimmer's z axis or along its x axis.
Bead read_bead(Reader bead) {
  Bead result;
  result.shape = read_shape(bead);
  const bool capsule = result.shape.kind == ShapeKind::capsule;
  const auto orientation =
      bead.choice("orientation", orientation_names, capsule ? std::nullopt : std::optional(BeadOrientation::parallel));
  if (capsule && orientation == BeadOrientation::perpendicular)
    result.orientation_wxyz = rotation_from_z(Eigen::Vector3d::UnitX());
  return result;
}

BeadOrientation orientation_of(const Bead& bead) {
  return z_axis(bead.orientation_wxyz).z() > 0.5 ? BeadOrientation::parallel : BeadOrientation::perpendicular;
}

Stroke read_stroke(Reader stroke) {
  Stroke result;
  result.amplitude_N = stroke.number("amplitude_N", Range::any);
  result.period_steps = stroke.integer("period_steps", Range::positive);
  result.phase_lag_steps = stroke.integer("phase_lag_steps", Range::not_negative);
  result.cycles = stroke.integer("cycles", Range::positive);
  constexpr std::int64_t most_steps = 1'000'000'000'000;
  if (result.period_steps > 0 && result.cycles > most_steps / result.period_steps) {
    stroke.reject("cycles",
                  "is " + std::to_string(result.cycles) + " (more steps than can be counted). Use fewer cycles.");
    result.cycles = 1;
  }
  return result;
}

/// The two drives of the stroke: trailing and leading pair of beads are pushed apart by
///   a sin(2π t/T)          for 0 ≤ t < cycles·T       [paper, eq. (19)]
///   a sin(2π (t − φ)/T)    for φ ≤ t < cycles·T + φ   [paper, eq. (20), with the delay its text describes]
Drive drive_of(const Stroke& stroke, std::int64_t lag_steps) {
  Signal signal;
  signal.kind = SignalKind::sinusoid;
  signal.amplitude = stroke.amplitude_N;
  signal.period_steps = stroke.period_steps;
  signal.lag_steps = static_cast<double>(lag_steps);
  signal.start_step = lag_steps;
  signal.stop_step = stroke.cycles * stroke.period_steps + lag_steps;
  return {DriveKind::pair_force, std::move(signal)};
}

std::vector<Bead> read_beads(Reader& swimmer) {
  constexpr std::array names{"B2", "B1", "B3"};
  std::vector<Bead> result(names.size());
  const std::size_t beads = swimmer.size("beads");
  if (beads != names.size()) {
    swimmer.reject("beads",
                   "has " + std::to_string(beads) +
                       " entries (a swimmer without arms has three). List trailing, middle and leading bead, or "
                       "give arms.");
  }
  const double mass_kg = swimmer.number("bead_mass_kg", Range::positive);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (beads == names.size()) result[i] = read_bead(swimmer.item("beads", i));
    result[i].name = names[i];
    result[i].mass_kg = mass_kg;
  }
  return result;
}

void read_figures(Reader& section, std::initializer_list<const char*> keys, const std::string& prefix,
                  PublishedFigures& figures) {
  for (const char* key : keys) {
    if (section.has(key)) figures.emplace_back(prefix + key, section.number(key, Range::any));
  }
}

}  // namespace

void read_three_beads(Reader& swimmer, Swimmer& result) {
  result.beads = read_beads(swimmer);
  const Eigen::Vector2d gaps = swimmer.numbers("rest_gap_m", 2);
  Arm arm;
  {
    Reader spring = swimmer.section("spring");
    arm.stiffness_N_per_m = spring.number("stiffness_N_per_m", Range::positive);
    arm.damping_N_s_per_m = read_damping(spring, arm.stiffness_N_per_m, result.beads[0].mass_kg);
  }
  const Stroke stroke = read_stroke(swimmer.section("stroke"));
  result.three_beads = ThreeBeads{{gaps[0], gaps[1]}, stroke};
  for (int i = 0; i < 2; ++i) {
    arm.bead_A = i;
    arm.bead_B = i + 1;
    const Bead& A = result.beads[static_cast<std::size_t>(i)];
    const Bead& B = result.beads[static_cast<std::size_t>(i) + 1];
    arm.rest_length_m = gaps[i] + (extent_along_m(A) + extent_along_m(B)) / 2.0;
    arm.drive = drive_of(stroke, i == 0 ? 0 : stroke.phase_lag_steps);
    result.arms.push_back(arm);
  }
  result.beads[0].position_m.z() = -result.arms[0].rest_length_m;
  result.beads[2].position_m.z() = result.arms[1].rest_length_m;
}

void add_three_beads(ordered_json& section, const Swimmer& swimmer) {
  for (const Bead& bead : swimmer.beads) {
    ordered_json& item = section["beads"].emplace_back();
    add_shape(item, bead.shape);
    item["orientation"] = name_of(orientation_names, orientation_of(bead));
  }
  const auto& [rest_gap_m, stroke] = *swimmer.three_beads;
  section["bead_mass_kg"] = swimmer.beads[0].mass_kg;
  section["rest_gap_m"] = rest_gap_m;
  section["spring"] = {{"stiffness_N_per_m", swimmer.arms[0].stiffness_N_per_m},
                       {"damping_N_s_per_m", swimmer.arms[0].damping_N_s_per_m}};
  section["stroke"] = {{"amplitude_N", stroke.amplitude_N},
                       {"period_steps", stroke.period_steps},
                       {"phase_lag_steps", stroke.phase_lag_steps},
                       {"cycles", stroke.cycles}};
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

ordered_json resolved_published(const PublishedFigures& figures) {
  const std::string of_bodies = "Re_bodies.";
  ordered_json section = ordered_json::object();
  for (const auto& [key, value] : figures) {
    if (key.starts_with(of_bodies))
      section["Re_bodies"][key.substr(of_bodies.size())] = value;
    else
      section[key] = value;
  }
  return section;
}

}  // namespace copepod::coupler
