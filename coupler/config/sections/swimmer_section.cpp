#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <span>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// The swimmer's frame in the world: its quaternion, or the shortest rotation of its z axis to `axis`.
void declare_frame(Keys& keys, Eigen::Vector4d& orientation_wxyz) {
  if (keys.when(keys.has("axis"))) {
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    declare_direction(keys, "axis", axis,
                      "World direction of the swimmer's own z axis, reached by the shortest rotation; it is "
                      "normalised. The shorthand and chains lie along it.");
    orientation_wxyz = rotation_from_z(axis);
    keys.reject_if(keys.has("orientation_wxyz"), "orientation_wxyz",
                   "is given together with axis (both turn the swimmer). Remove one.");
    if (keys.reads()) return;
  }
  declare_orientation(keys, orientation_wxyz,
                      "Orientation of the swimmer's frame at the start: unit quaternion, instead of axis.");
}

/// Half of a bead's extent along a unit vector of the swimmer's frame [m]: r + |d·e| L/2.
double half_extent_m(const Bead& bead, const Eigen::Vector3d& direction) {
  const double cosine = std::abs(z_axis(bead.orientation_wxyz).dot(direction));
  const bool across = cosine < 1e-15;  // to rounding
  return bead.shape.radius_m + (across ? 0.0 : 0.5 * cosine * bead.shape.length_m);
}

constexpr const char* beads_description =
    "The beads; of the shorthand trailing, middle and leading. Beads without position_m form a chain along z, in this "
    "order, from the rest gaps of their arms.";

void declare_bead(Keys& keys, Bead& bead) {
  keys.name(keys.needed("name"), bead.name, "Name of the bead, where there are arms; its body is NAME.BEAD.");
  declare(keys, bead.shape);
  declare_mass(keys, bead);
  keys.numbers({"position_m", Need::in_some_cases}, bead.position_m,
               "Centre in the swimmer's frame [m]; of all beads or of none.");
  declare_orientation(
      keys, bead.orientation_wxyz,
      "Orientation in the swimmer's frame: unit quaternion. Capsules and cylinders lie along their own z axis.");
}

/// Declares the swimmer's beads; true if they have places, false if their arms place them.
bool declare_beads(Keys& keys, Swimmer& swimmer) {
  keys.list(required("beads"), swimmer.beads, beads_description, declare_bead);
  if (!keys.reads()) return true;
  const std::size_t count = swimmer.beads.size();
  std::size_t placed = 0;
  for (std::size_t i = 0; i < count; ++i)
    if (keys.raw("beads")->items[i].find("position_m") != nullptr) ++placed;
  std::set<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& name = swimmer.beads[i].name;
    if (!name.empty() && !names.insert(name).second)
      keys.problems().error(keys.path_of("beads") + "." + std::to_string(i),
                            "two beads of " + swimmer.name + " are called '" + name +
                                "' (arms, springs and results need one each). Rename one of them.");
  }
  keys.reject_if(count == 0, "beads", "is empty (arms join beads). List them by name.");
  keys.reject_if(placed != 0 && placed != count, "beads",
                 "have position_m only in part (either all have one, or the beads form a chain). Give all or none.");
  return placed == count;
}

/// The number of a bead by its name; reports one that is not there.
int number_of_bead(Keys& keys, const Swimmer& swimmer, const std::string& name) {
  const auto found = std::ranges::find(swimmer.beads, name, &Bead::name);
  if (found != swimmer.beads.end()) return static_cast<int>(found - swimmer.beads.begin());
  if (name.empty()) return 0;  // reported when it was read
  std::set<std::string> known;
  for (const Bead& bead : swimmer.beads) known.insert(bead.name);
  keys.reject("beads", "names the bead '" + name + "' (" + swimmer.name +
                           " has none of this name). Known: " + listed({known.begin(), known.end()}) + ".");
  return 0;
}

/// @param remedy  "why). What to do."
void declare_beads_of(Keys& keys, const Swimmer& swimmer, const std::vector<int*>& numbers, const std::string& remedy,
                      const char* description) {
  std::vector<std::string> names;
  if (keys.resolved() != nullptr)
    for (const int* number : numbers) names.push_back(swimmer.beads[*number].name);
  declare_names(keys, required("beads"), names, numbers.size(), remedy, description);
  if (!keys.reads()) return;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    *numbers[i] = number_of_bead(keys, swimmer, names[i]);
    if (!names[i].empty() && !seen.insert(names[i]).second)
      keys.reject("beads", "names the bead '" + names[i] + "' twice (" + remedy);
  }
}

/// Stiffness and damping of an arm: γ as given, or from the damping ratio D = γ / (2 √(m k))   [paper, eq. (11)]
/// @param mass_kg  of each bead, where they differ twice the reduced mass
void declare_spring(Keys& keys, Arm& arm, double mass_kg) {
  keys.number(required("stiffness_N_per_m"), arm.stiffness_N_per_m, Range::positive, "Stiffness k.");
  keys.number("damping_N_s_per_m", arm.damping_N_s_per_m, Range::not_negative, "Damping γ.");
  std::optional<double> ratio;
  keys.number(
      "damping_ratio", ratio, Range::not_negative,
      "Damping ratio D = γ / (2 √(m k)) instead of γ; for beads of different mass m is twice the reduced mass.");
  if (!ratio) return;
  keys.reject_if(keys.has("damping_N_s_per_m"), "damping_ratio",
                 "is given together with damping_N_s_per_m (one follows from the other). Remove one.");
  arm.damping_N_s_per_m = 2.0 * *ratio * std::sqrt(mass_kg * arm.stiffness_N_per_m);
}

/// What the free length of an arm's spring is given as.
struct RestLength {
  std::optional<double> gap_m;     ///< surface to surface
  std::optional<double> length_m;  ///< centre to centre
};

/// Twice the reduced mass of two beads [kg].
double mass_of_arm_kg(const Arm& arm, const Swimmer& swimmer) {
  if (swimmer.beads.empty()) return 1.0;
  const double A = swimmer.beads[arm.body_A].mass_kg;
  const double B = swimmer.beads[arm.body_B].mass_kg;
  return A == B ? A : 2.0 * A * B / (A + B);
}

void declare_rest_length(Keys& keys, RestLength& rest) {
  if (keys.written_if(false))
    keys.number("rest_gap_m", rest.gap_m, Range::positive, "Free distance between the surfaces at rest [m].");
  keys.number("rest_length_m", rest.length_m, Range::positive,
              "Free distance between the centres [m], instead of rest_gap_m. By default that of the beads' places.");
  keys.reject_if(rest.gap_m && rest.length_m, "rest_length_m",
                 "is given together with rest_gap_m (one follows from the other). Remove one.");
}

/// @param rest  of the arm's spring, as it is given
void declare_arm(Keys& keys, Arm& arm, const Swimmer& swimmer, double step_s, RestLength& rest) {
  declare_beads_of(keys, swimmer, {&arm.body_A, &arm.body_B}, "an arm joins two). Write beads: [A, B].",
                   "Names of both beads.");
  keys.section(required("spring"), "Spring between the centres of both beads.", [&](Keys& spring) {
    declare_spring(spring, arm, mass_of_arm_kg(arm, swimmer));
    declare_rest_length(spring, rest);
  });
  keys.section<Drive>("drive", arm.drive, "What drives the arm.",
                      [&](Keys& below, Drive& drive) { declare(below, drive, step_s); });
}

double rest_length_m(const RestLength& rest, const Bead& A, const Bead& B) {
  const Eigen::Vector3d d_AB_m = B.position_m - A.position_m;
  if (rest.length_m) return *rest.length_m;
  if (!rest.gap_m) return d_AB_m.norm();
  const Eigen::Vector3d direction =
      d_AB_m.isZero(0.0) ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(d_AB_m.normalized());
  return *rest.gap_m + (half_extent_m(A, direction) + half_extent_m(B, direction));
}

/// Puts beads without places in a row along z, from the rest lengths of the arms between neighbours; the origin is
/// the middle bead, or half-way between the two in the middle.
void place_chain(Keys& keys, Swimmer& result, const std::vector<RestLength>& rests) {
  std::vector<Bead>& beads = result.beads;
  for (std::size_t i = 0; i + 1 < beads.size(); ++i) {
    const auto joins = [&](const Arm& arm) {
      return std::abs(arm.body_A - arm.body_B) == 1 && std::min(arm.body_A, arm.body_B) == static_cast<int>(i);
    };
    const auto arm = std::find_if(result.arms.begin(), result.arms.end(), joins);
    const RestLength rest = arm == result.arms.end() ? RestLength{} : rests[arm - result.arms.begin()];
    if (!rest.gap_m && !rest.length_m)
      return keys.reject("beads", "have no position_m, and no arm with a rest_gap_m joins '" + beads[i].name +
                                      "' to '" + beads[i + 1].name +
                                      "' (a chain follows from its arms). Give the arm, or the places of all beads.");
    beads[i + 1].position_m.z() = beads[i].position_m.z() + rest_length_m(rest, beads[i], beads[i + 1]);
  }
  const double origin_m = 0.5 * (beads[(beads.size() - 1) / 2].position_m.z() + beads[beads.size() / 2].position_m.z());
  for (Bead& bead : beads) bead.position_m.z() -= origin_m;
}

/// A swimmer of any shape.
void declare_general(Keys& keys, Swimmer& swimmer, double step_s) {
  const bool placed = declare_beads(keys, swimmer);
  if (swimmer.beads.empty()) {
    for (const char* key : {"arms", "bends"}) static_cast<void>(keys.raw(key));
    return;
  }
  std::vector<RestLength> rests;
  for (const Arm& arm : swimmer.arms) rests.push_back({{}, arm.rest_length_m});
  keys.list<Arm>("arms", swimmer.arms, "Springs between beads, and what drives them.", [&](Keys& below, Arm& arm) {
    rests.resize(swimmer.arms.size());
    declare_arm(below, arm, swimmer, step_s, rests[&arm - swimmer.arms.data()]);
  });
  if (keys.reads()) {
    if (!placed && !keys.has_errors("arms")) place_chain(keys, swimmer, rests);
    for (std::size_t i = 0; i < swimmer.arms.size(); ++i) {
      Arm& arm = swimmer.arms[i];
      arm.rest_length_m = rest_length_m(rests[i], swimmer.beads[arm.body_A], swimmer.beads[arm.body_B]);
    }
  }
  keys.list<BendSpecification>(
      "bends", swimmer.bends, "Springs of angles between arms.", [&](Keys& below, BendSpecification& bend) {
        declare_beads_of(below, swimmer, {&bend.body_A, &bend.body_B, &bend.body_C},
                         "a bend has three, the vertex in the middle). Write beads: [A, B, C].",
                         "Names of three beads, the vertex in the middle.");
        declare(below, bend);
      });
}

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
  if (keys.reads() && is_capsule && orientation == BeadOrientation::perpendicular)
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
  if (stroke.period_steps <= 0 || stroke.cycles <= most_steps / stroke.period_steps) return;
  keys.reject("cycles", "is " + std::to_string(stroke.cycles) + " (more steps than can be counted). Use fewer cycles.");
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
  const std::size_t beads = keys.reads() ? keys.size("beads") : bead_names.size();
  if (beads == bead_names.size())
    keys.list(required("beads"), swimmer.beads, beads_description, declare_bead_of_row);
  else
    keys.reject(
        "beads",
        "has " + std::to_string(beads) +
            " entries (a swimmer without arms has three). List trailing, middle and leading bead, or give arms.");
  swimmer.beads.resize(bead_names.size());
  keys.number(keys.needed("bead_mass_kg"), swimmer.beads[0].mass_kg, Range::positive, "Shorthand: mass of each bead.");
  if (!keys.reads()) return;
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

/// The shorthand's own keys: beads B2, B1, B3 in a row along z, B1 at the origin.
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
  if (keys.reads()) place_in_a_row(swimmer, arm);
}

constexpr std::array figures_of_swimmer{
    DescribedKey{"u_swim_lattice", "Swimming speed [cells/step]."},
    DescribedKey{"d1_cells", "Amplitude of the trailing arm."},
    DescribedKey{"d2_cells", "Amplitude of the leading arm."},
    DescribedKey{"sin_dphi", "Sine of the phase difference of both arms."},
    DescribedKey{"K", "Geometry factor [1/cell]."},
    DescribedKey{"u_GA_lattice", "Speed after Golestanian and Ajdari [cells/step]."},
    DescribedKey{"error_percent", "Difference of both speeds, or a bound on it."},
    DescribedKey{"efficiency", "Swimming efficiency."},
    DescribedKey{"Re_swim", "Reynolds number of the swimmer."}};
constexpr std::array figures_of_bodies{DescribedKey{"B2", "Trailing bead."}, DescribedKey{"B1", "Middle bead."},
                                       DescribedKey{"B3", "Leading bead."}};

void declare_figures(Keys& keys, std::span<const DescribedKey> known, const std::string& prefix,
                     PublishedFigures& figures) {
  for (const DescribedKey& figure : known) {
    const auto found = std::ranges::find(figures, prefix + figure.name, &PublishedFigures::value_type::first);
    std::optional<double> value;
    if (found != figures.end()) value = found->second;
    keys.number(figure.name, value, Range::any, figure.description);
    if (keys.reads() && value) figures.emplace_back(prefix + figure.name, *value);
  }
}

void declare(Keys& keys, PublishedFigures& figures) {
  const std::string prefix = "Re_bodies.";
  declare_figures(keys, figures_of_swimmer, "", figures);
  const bool has_any =
      std::ranges::any_of(figures, [&](const auto& figure) { return figure.first.starts_with(prefix); });
  if (keys.written_if(has_any))
    keys.section("Re_bodies", "Reynolds numbers of the beads, in the columns of the publication.",
                 [&](Keys& bodies) { declare_figures(bodies, figures_of_bodies, prefix, figures); });
}

void declare_phase(Keys& keys, double& phase_deg) {
  keys.number("phase_deg", phase_deg, Range::any,
              "Phase of the swimmer in degrees: every signal with a period runs late by that part of it, its start and "
              "stop included.");
  std::optional<double> phase_rad;
  keys.number("phase_rad", phase_rad, Range::any, "The same in radians.");
  if (!phase_rad) return;
  keys.reject_if(keys.has("phase_deg"), "phase_deg",
                 "is given together with phase_rad (both set the same). Remove one.");
  phase_deg = *phase_rad * (180.0 / std::numbers::pi);
}

}  // namespace

double extent_along_m(const Bead& bead) { return 2.0 * half_extent_m(bead, Eigen::Vector3d::UnitZ()); }

void declare(Keys& keys, Swimmer& swimmer, double step_s, bool has_center) {
  keys.name(required("name"), swimmer.name,
            "Name; its bodies are NAME.BEAD, of the shorthand NAME.B2, NAME.B1 and NAME.B3.");
  if (has_center)
    keys.numbers(required("center_m"), swimmer.center_m,
                 "Origin of the swimmer's frame at the start [m]: of the shorthand the centre of the middle bead, of a "
                 "chain its middle.");
  declare_frame(keys, swimmer.orientation_wxyz);
  declare_phase(keys, swimmer.phase_deg);
  const bool is_general = keys.reads() ? keys.has("arms") : !swimmer.three_beads;
  if (keys.when(is_general)) declare_general(keys, swimmer, step_s);
  if (keys.when(!is_general)) declare_three_beads(keys, swimmer);
  keys.describe_also(
      {{"anyOf", {{{"required", {"arms"}}}, {{"required", {"bead_mass_kg", "rest_gap_m", "spring", "stroke"}}}}}});
  if (keys.written_if(!swimmer.published.empty()))
    keys.section("published",
                 "Published figures of a three-bead swimmer, shown beside the computed ones, which are evaluated in "
                 "the way of the paper too (as_in_paper). They change no motion.",
                 [&](Keys& published) { declare(published, swimmer.published); });
}

}  // namespace copepod::coupler
