#include <cmath>
#include <initializer_list>

#include "config/sections/sections.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

/// Shortest rotation that takes the z axis to the unit vector `direction`.
///   q = (√((1 + c)/2), z × d / (2 q_w)),  c = z · d
Eigen::Vector4d rotation_from_z(const Eigen::Vector3d& direction) {
  const double c = direction.z();
  if (c >= 1.0) return {1, 0, 0, 0};
  if (c <= -1.0) return {0, 1, 0, 0};
  const double w = std::sqrt((1.0 + c) / 2.0);
  return {w, -direction.y() / (2.0 * w), direction.x() / (2.0 * w), 0.0};
}

/// The swimmer's frame in the world: its quaternion, or the shortest rotation of its z axis to `axis`.
Eigen::Vector4d read_frame(Reader& swimmer) {
  if (!swimmer.has("axis")) return read_orientation(swimmer);
  if (swimmer.has("orientation_wxyz")) {
    swimmer.problems().error(
        swimmer.path_of("orientation_wxyz"),
        swimmer.path_of("orientation_wxyz") + " is given together with axis (both turn the swimmer). Remove one.");
  }
  return rotation_from_z(read_direction(swimmer, "axis", Eigen::Vector3d::UnitZ()));
}

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

std::vector<Bead> read_three_beads(Reader& swimmer) {
  constexpr std::array names{"B2", "B1", "B3"};
  std::vector<Bead> result(names.size());
  const std::size_t beads = swimmer.size("beads");
  if (beads != names.size()) {
    swimmer.problems().error(swimmer.path_of("beads"),
                             swimmer.path_of("beads") + " has " + std::to_string(beads) +
                                 " entries (a swimmer has three). List trailing, middle and leading bead.");
  }
  const double mass_kg = swimmer.number("bead_mass_kg", Range::positive);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (beads == names.size()) result[i] = read_bead(swimmer.item("beads", i));
    result[i].name = names[i];
    result[i].mass_kg = mass_kg;
  }
  return result;
}

/// The shorthand: beads B2, B1, B3 in a row along z, B1 at the origin.
void read_three_bead_swimmer(Reader& swimmer, Swimmer& result) {
  result.beads = read_three_beads(swimmer);
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
    const Bead& B = result.beads[static_cast<std::size_t>(i + 1)];
    arm.rest_length_m = gaps[i] + (extent_along_m(A) + extent_along_m(B)) / 2.0;
    arm.drive = drive_of(stroke, i == 0 ? 0 : stroke.phase_lag_steps);
    result.arms.push_back(arm);
  }
  result.beads[0].position_m.z() = -result.arms[0].rest_length_m;
  result.beads[2].position_m.z() = result.arms[1].rest_length_m;
}

}  // namespace

double extent_along_m(const Bead& bead) {
  return 2.0 * bead.shape.radius_m + std::abs(z_axis(bead.orientation_wxyz).z()) * bead.shape.length_m;
}

Swimmer read_swimmer(Reader swimmer) {
  Swimmer result;
  result.name = swimmer.text("name");
  result.center_m = swimmer.numbers("center_m", 3);
  result.orientation_wxyz = read_frame(swimmer);
  read_three_bead_swimmer(swimmer, result);
  result.published = read_published(swimmer.section("published"));
  return result;
}

Value resolved_swimmer(const Swimmer& swimmer) {
  Value section = Value::mapping();
  section.add("name", Value::of_text(swimmer.name));
  section.add("center_m", Value::of_vector(swimmer.center_m));
  section.add("orientation_wxyz", Value::of_vector(swimmer.orientation_wxyz));
  Value beads = Value::sequence();
  for (const Bead& bead : swimmer.beads) {
    Value item = Value::mapping();
    add_shape(item, bead.shape);
    beads.add(std::move(item.add("orientation", word(orientation_names, orientation_of(bead)))));
  }
  section.add("beads", std::move(beads));
  section.add("bead_mass_kg", Value::of_number(swimmer.beads[0].mass_kg));
  const auto& [rest_gap_m, stroke] = *swimmer.three_beads;
  section.add("rest_gap_m", Value::of_vector(Eigen::Vector2d(rest_gap_m[0], rest_gap_m[1])));
  Value spring = Value::mapping();
  spring.add("stiffness_N_per_m", Value::of_number(swimmer.arms[0].stiffness_N_per_m));
  spring.add("damping_N_s_per_m", Value::of_number(swimmer.arms[0].damping_N_s_per_m));
  section.add("spring", std::move(spring));
  Value driven = Value::mapping();
  driven.add("amplitude_N", Value::of_number(stroke.amplitude_N));
  driven.add("period_steps", Value::of_integer(stroke.period_steps));
  driven.add("phase_lag_steps", Value::of_integer(stroke.phase_lag_steps));
  driven.add("cycles", Value::of_integer(stroke.cycles));
  section.add("stroke", std::move(driven));
  if (!swimmer.published.empty()) section.add("published", resolved_published(swimmer.published));
  return section;
}

}  // namespace copepod::coupler
