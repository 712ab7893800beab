#include <algorithm>
#include <span>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "geometry/rotation.hpp"

// What only the paper's swimmers have: the shorthand for three beads in a row, and published figures.

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// A bead of the shorthand: a capsule lies along the swimmer's z axis or along its x axis.
void declare_bead_of_row(Keys& keys, Bead& bead) {
  declare(keys, bead.shape);
  keys.reject_if(!is_round(bead.shape), "shape",
                 "is none of sphere and capsule (the shorthand has these). Give the swimmer arms.");
  const bool is_capsule = bead.shape.kind == ShapeKind::capsule;
  auto orientation =
      z_axis(bead.orientation_wxyz).z() > 0.5 ? BeadOrientation::parallel : BeadOrientation::perpendicular;
  keys.choice(
      is_capsule ? keys.needed("orientation") : Key("orientation"), orientation, orientation_names,
      "Of a capsule of the shorthand: along the swimmer's z axis (parallel) or along its x axis (perpendicular).");
  if (keys.reader() != nullptr && is_capsule && orientation == BeadOrientation::perpendicular)
    bead.orientation_wxyz = rotation_from_z(Eigen::Vector3d::UnitX());
}

void declare(Keys& keys, Stroke& stroke) {
  keys.number(required("amplitude_N"), stroke.amplitude_N, Range::any, "Amplitude a.");
  keys.integer(required("period_steps"), stroke.period_steps, Range::positive, "Period T in steps.");
  keys.describe_also("period_steps", {{"minimum", 20}});
  keys.integer(required("phase_lag_steps"), stroke.phase_lag_steps, Range::not_negative,
               "Delay φ of the leading bead in steps.");
  keys.integer(required("cycles"), stroke.cycles, Range::positive, "Number of periods.");
  constexpr std::int64_t most_steps = 1'000'000'000'000;
  Reader* reader = keys.reader();
  if (reader == nullptr || stroke.period_steps <= 0 || stroke.cycles <= most_steps / stroke.period_steps) return;
  reader->reject("cycles",
                 "is " + std::to_string(stroke.cycles) + " (more steps than can be counted). Use fewer cycles.");
  stroke.cycles = 1;
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

constexpr std::array bead_names{"B2", "B1", "B3"};

void declare_row(Keys& keys, Swimmer& swimmer) {
  Reader* reader = keys.reader();
  const std::size_t beads = reader != nullptr ? reader->size("beads") : bead_names.size();
  if (beads == bead_names.size())
    keys.list(required("beads"), swimmer.beads, beads_description, declare_bead_of_row);
  else
    reader->reject(
        "beads",
        "has " + std::to_string(beads) +
            " entries (a swimmer without arms has three). List trailing, middle and leading bead, or give arms.");
  swimmer.beads.resize(bead_names.size());
  keys.number(keys.needed("bead_mass_kg"), swimmer.beads[0].mass_kg, Range::positive, "Shorthand: mass of each bead.");
  if (reader == nullptr) return;
  for (std::size_t i = 0; i < bead_names.size(); ++i) {
    swimmer.beads[i].name = bead_names[i];
    swimmer.beads[i].mass_kg = swimmer.beads[0].mass_kg;
  }
}

/// Both arms of the row, from what the shorthand gives.
void place_in_a_row(Swimmer& swimmer, Arm arm) {
  const ThreeBeads& row = *swimmer.three_beads;
  for (int i = 0; i < 2; ++i) {
    arm.body_A = i;
    arm.body_B = i + 1;
    const Bead& A = swimmer.beads[i];
    const Bead& B = swimmer.beads[static_cast<std::size_t>(i) + 1];
    arm.rest_length_m = row.rest_gap_m[i] + (extent_along_m(A) + extent_along_m(B)) / 2.0;
    arm.drive = drive_of(row.stroke, i == 0 ? 0 : row.stroke.phase_lag_steps);
    swimmer.arms.push_back(arm);
  }
  swimmer.beads[0].position_m.z() = -swimmer.arms[0].rest_length_m;
  swimmer.beads[2].position_m.z() = swimmer.arms[1].rest_length_m;
}

}  // namespace

void declare_three_beads(Keys& keys, Swimmer& swimmer) {
  declare_row(keys, swimmer);
  if (!swimmer.three_beads) swimmer.three_beads.emplace();
  keys.numbers(
      keys.needed("rest_gap_m"), swimmer.three_beads->rest_gap_m,
      "Shorthand: distances between the beads at rest, surface to surface: trailing to middle, middle to leading [m].");
  Arm arm = swimmer.arms.empty() ? Arm{} : swimmer.arms[0];
  keys.section(keys.needed("spring"), "Shorthand: both springs; they start at rest.",
               [&](Keys& spring) { declare_spring(spring, arm, swimmer.beads[0].mass_kg); });
  keys.section(keys.needed("stroke"),
               "Shorthand: driving: −a sin(2πt/T) on the trailing bead, a sin(2π(t−φ)/T) on the leading one from t = "
               "φ, the negative sum on the middle one; each for `cycles` periods.",
               [&](Keys& stroke) { declare(stroke, swimmer.three_beads->stroke); });
  if (keys.reader() != nullptr) place_in_a_row(swimmer, arm);
}

namespace {

struct Figure {
  const char* key;
  const char* description;
};

constexpr std::array figures_of_swimmer{Figure{"u_swim_lattice", "Swimming speed [cells/step]."},
                                        Figure{"d1_cells", "Amplitude of the trailing arm."},
                                        Figure{"d2_cells", "Amplitude of the leading arm."},
                                        Figure{"sin_dphi", "Sine of the phase difference of both arms."},
                                        Figure{"K", "Geometry factor [1/cell]."},
                                        Figure{"u_GA_lattice", "Speed after Golestanian and Ajdari [cells/step]."},
                                        Figure{"error_percent", "Difference of both speeds, or a bound on it."},
                                        Figure{"efficiency", "Swimming efficiency."},
                                        Figure{"Re_swim", "Reynolds number of the swimmer."}};
constexpr std::array figures_of_bodies{Figure{"B2", "Trailing bead."}, Figure{"B1", "Middle bead."},
                                       Figure{"B3", "Leading bead."}};

void declare_figures(Keys& keys, std::span<const Figure> known, const std::string& prefix, PublishedFigures& figures) {
  for (const Figure& figure : known) {
    const auto found = std::ranges::find(figures, prefix + figure.key, &PublishedFigures::value_type::first);
    std::optional<double> value;
    if (found != figures.end()) value = found->second;
    keys.number(figure.key, value, Range::any, figure.description);
    if (keys.reader() != nullptr && value) figures.emplace_back(prefix + figure.key, *value);
  }
}

}  // namespace

void declare(Keys& keys, PublishedFigures& figures) {
  const std::string prefix = "Re_bodies.";
  declare_figures(keys, figures_of_swimmer, "", figures);
  const bool has_any =
      std::ranges::any_of(figures, [&](const auto& figure) { return figure.first.starts_with(prefix); });
  if (keys.written_if(has_any))
    keys.section("Re_bodies", "Reynolds numbers of the beads, in the columns of the publication.",
                 [&](Keys& bodies) { declare_figures(bodies, figures_of_bodies, prefix, figures); });
}

}  // namespace copepod::coupler
