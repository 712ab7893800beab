#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// Shortest rotation that takes the z axis to the unit vector `direction`.
///   q = (q_w, z × d / (2 q_w)),  q_w = √((1 + c)/2) = |z × d| / √(2 (1 − c)),  c = z · d
/// The second form of q_w loses no digits near −z.
Eigen::Vector4d rotation_from_z(const Eigen::Vector3d& direction) {
  const double c = direction.z();
  const double s = std::hypot(direction.x(), direction.y());
  if (s == 0.0) return c > 0.0 ? Eigen::Vector4d(1, 0, 0, 0) : Eigen::Vector4d(0, 1, 0, 0);
  const double w = c >= 0.0 ? std::sqrt((1.0 + c) / 2.0) : s / std::sqrt(2.0 * (1.0 - c));
  return Eigen::Vector4d(w, -direction.y() / (2.0 * w), direction.x() / (2.0 * w), 0.0).normalized();
}

/// The swimmer's frame in the world: its quaternion, or the shortest rotation of its z axis to `axis`.
Eigen::Vector4d read_frame(Reader& swimmer) {
  if (!swimmer.has("axis")) return read_orientation(swimmer);
  if (swimmer.has("orientation_wxyz")) {
    swimmer.reject("orientation_wxyz", "is given together with axis (both turn the swimmer). Remove one.");
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
    stroke.reject("cycles",
                  "is " + std::to_string(result.cycles) + " (more steps than can be counted). Use fewer cycles.");
    result.cycles = 1;
  }
  return result;
}

/// γ as given, or from the damping ratio D = γ / (2 √(m k))   [paper, eq. (11)]
/// @param mass_kg  of each body, where they differ twice the reduced mass
double read_damping(Reader& spring, double stiffness_N_per_m, double mass_kg) {
  const double given = spring.number("damping_N_s_per_m", Range::not_negative, 0.0);
  if (!spring.has("damping_ratio")) return given;
  const double ratio = spring.number("damping_ratio", Range::not_negative, 0.0);
  if (spring.has("damping_N_s_per_m")) {
    spring.reject("damping_ratio",
                  "is given together with damping_N_s_per_m (one follows from the other). Remove one.");
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
    const Bead& B = result.beads[static_cast<std::size_t>(i) + 1];
    arm.rest_length_m = gaps[i] + (extent_along_m(A) + extent_along_m(B)) / 2.0;
    arm.drive = drive_of(stroke, i == 0 ? 0 : stroke.phase_lag_steps);
    result.arms.push_back(arm);
  }
  result.beads[0].position_m.z() = -result.arms[0].rest_length_m;
  result.beads[2].position_m.z() = result.arms[1].rest_length_m;
}

/// Half of a bead's extent along a unit vector of the swimmer's frame [m]: r + |d·e| L/2.
double half_extent_m(const Bead& bead, const Eigen::Vector3d& direction) {
  const double cosine = std::abs(z_axis(bead.orientation_wxyz).dot(direction));
  const bool across = cosine < 1e-15;  // to rounding
  return bead.shape.radius_m + (across ? 0.0 : 0.5 * cosine * bead.shape.length_m);
}

Bead read_named_bead(Reader bead) {
  Bead result;
  result.name = bead.text("name");
  result.shape = read_shape(bead);
  if (bead.has("density_kg_per_m3") == bead.has("mass_kg")) {
    bead.reject("mass_kg",
                "and density_kg_per_m3 are both given, or neither (one follows "
                "from the other). Give exactly one.");
  }
  result.mass_kg = bead.has("mass_kg")
                       ? bead.number("mass_kg", Range::positive)
                       : bead.number("density_kg_per_m3", Range::positive, 1.0) * volume_m3(result.shape);
  if (bead.has("position_m")) result.position_m = bead.numbers("position_m", 3);
  result.orientation_wxyz = read_orientation(bead);
  return result;
}

/// Reads the swimmer's beads; true if they have places, false if their arms place them.
bool read_named_beads(Reader& swimmer, Swimmer& result) {
  std::size_t placed = 0;
  const std::size_t count = swimmer.size("beads");
  for (std::size_t i = 0; i < count; ++i) {
    const Value* position = swimmer.raw("beads")->items[i].find("position_m");
    if (position != nullptr) ++placed;
    result.beads.push_back(read_named_bead(swimmer.item("beads", i)));
  }
  if (count == 0) {
    swimmer.reject("beads", "is empty (arms join beads). List them by name.");
  } else if (placed != 0 && placed != count) {
    swimmer.reject("beads",
                   "have position_m only in part (either all have one, or the "
                   "beads form a chain). Give all or none.");
  }
  return placed == count;
}

/// Numbers of the beads that `beads` names; reports those that are not there, or are there twice.
std::vector<int> read_bead_numbers(Reader& reader, const Swimmer& swimmer, std::size_t count,
                                   const std::string& remedy) {
  std::vector<int> numbers;
  for (const std::string& name : read_names(reader, "beads", count, remedy)) {
    const auto found =
        std::find_if(swimmer.beads.begin(), swimmer.beads.end(), [&](const Bead& bead) { return bead.name == name; });
    if (found == swimmer.beads.end() && !name.empty()) {
      reader.reject("beads", "names the bead '" + name + "' (" + swimmer.name +
                                 " has none of this name). Use a name of its beads.");
    }
    const int number = found == swimmer.beads.end() ? 0 : static_cast<int>(found - swimmer.beads.begin());
    if (found != swimmer.beads.end() && std::find(numbers.begin(), numbers.end(), number) != numbers.end()) {
      reader.reject("beads", "names the bead '" + name + "' twice (" + remedy);
    }
    numbers.push_back(number);
  }
  return numbers;
}

/// What the free length of an arm's spring is given as.
struct RestLength {
  std::optional<double> gap_m;     ///< surface to surface
  std::optional<double> length_m;  ///< centre to centre
};

Arm read_arm(Reader arm, const Swimmer& swimmer, double step_s, RestLength& rest) {
  Arm result;
  const std::vector<int> beads = read_bead_numbers(arm, swimmer, 2, "an arm joins two). Write beads: [A, B].");
  result.bead_A = beads[0];
  result.bead_B = beads[1];
  {
    Reader spring = arm.section("spring");
    result.stiffness_N_per_m = spring.number("stiffness_N_per_m", Range::positive);
    double mass_kg = 1.0;
    if (!swimmer.beads.empty()) {
      const double A = swimmer.beads[static_cast<std::size_t>(result.bead_A)].mass_kg;
      const double B = swimmer.beads[static_cast<std::size_t>(result.bead_B)].mass_kg;
      mass_kg = A == B ? A : 2.0 * A * B / (A + B);
    }
    result.damping_N_s_per_m = read_damping(spring, result.stiffness_N_per_m, mass_kg);
    if (spring.has("rest_gap_m")) rest.gap_m = spring.number("rest_gap_m", Range::positive);
    if (spring.has("rest_length_m")) rest.length_m = spring.number("rest_length_m", Range::positive);
    if (rest.gap_m && rest.length_m) {
      spring.reject("rest_length_m", "is given together with rest_gap_m (one follows from the other). Remove one.");
    }
  }
  if (arm.has("drive")) result.drive = read_drive(arm.section("drive"), step_s);
  return result;
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
void place_chain(Reader& swimmer, Swimmer& result, const std::vector<RestLength>& rests) {
  std::vector<Bead>& beads = result.beads;
  for (std::size_t i = 0; i + 1 < beads.size(); ++i) {
    const auto joins = [&](const Arm& arm) {
      return std::abs(arm.bead_A - arm.bead_B) == 1 && std::min(arm.bead_A, arm.bead_B) == static_cast<int>(i);
    };
    const auto arm = std::find_if(result.arms.begin(), result.arms.end(), joins);
    const RestLength rest =
        arm == result.arms.end() ? RestLength{} : rests[static_cast<std::size_t>(arm - result.arms.begin())];
    if (!rest.gap_m && !rest.length_m) {
      swimmer.reject("beads", "have no position_m, and no arm with a rest_gap_m joins '" + beads[i].name + "' to '" +
                                  beads[i + 1].name +
                                  "' (a chain follows from its arms). Give the arm, or the places of all beads.");
      return;
    }
    beads[i + 1].position_m.z() = beads[i].position_m.z() + rest_length_m(rest, beads[i], beads[i + 1]);
  }
  const double origin_m = 0.5 * (beads[(beads.size() - 1) / 2].position_m.z() + beads[beads.size() / 2].position_m.z());
  for (Bead& bead : beads) bead.position_m.z() -= origin_m;
}

/// A swimmer of any shape.
void read_general_swimmer(Reader& swimmer, double step_s, Swimmer& result) {
  const bool placed = read_named_beads(swimmer, result);
  if (result.beads.empty()) {
    for (const char* key : {"arms", "bends"}) (void)swimmer.raw(key);
    return;
  }
  std::vector<RestLength> rests(swimmer.size("arms"));
  for (std::size_t i = 0; i < rests.size(); ++i)
    result.arms.push_back(read_arm(swimmer.item("arms", i), result, step_s, rests[i]));
  if (!placed) place_chain(swimmer, result, rests);
  for (std::size_t i = 0; i < rests.size(); ++i) {
    Arm& arm = result.arms[i];
    arm.rest_length_m = rest_length_m(rests[i], result.beads[static_cast<std::size_t>(arm.bead_A)],
                                      result.beads[static_cast<std::size_t>(arm.bead_B)]);
  }
  for (std::size_t i = 0; i < swimmer.size("bends"); ++i) {
    Reader bend = swimmer.item("bends", i);
    const std::vector<int> beads =
        read_bead_numbers(bend, result, 3, "a bend has three, the vertex in the middle). Write beads: [A, B, C].");
    read_bend(bend, result.bends.emplace_back(BendSpecification{beads[0], beads[1], beads[2]}));
  }
}

double read_phase_deg(Reader& swimmer) {
  if (!swimmer.has("phase_rad")) return swimmer.number("phase_deg", Range::any, 0.0);
  if (swimmer.has("phase_deg")) {
    swimmer.reject("phase_deg",
                   "is given together with phase_rad (both set the same). "
                   "Remove one.");
  }
  return swimmer.number("phase_rad", Range::any) * (180.0 / std::numbers::pi);
}

/// The shorthand's own keys.
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

void add_beads_and_arms(ordered_json& section, const Swimmer& swimmer) {
  const auto name = [&](int bead) { return swimmer.beads[static_cast<std::size_t>(bead)].name; };
  for (const Bead& bead : swimmer.beads) {
    ordered_json& item = section["beads"].emplace_back(ordered_json{{"name", bead.name}});
    add_shape(item, bead.shape);
    item["mass_kg"] = bead.mass_kg;
    item["position_m"] = bead.position_m;
    item["orientation_wxyz"] = bead.orientation_wxyz;
  }
  section["arms"] = ordered_json::array();
  for (const Arm& arm : swimmer.arms) {
    ordered_json& item = section["arms"].emplace_back();
    item["beads"] = {name(arm.bead_A), name(arm.bead_B)};
    item["spring"] = {{"stiffness_N_per_m", arm.stiffness_N_per_m},
                      {"damping_N_s_per_m", arm.damping_N_s_per_m},
                      {"rest_length_m", arm.rest_length_m}};
    if (arm.drive) item["drive"] = resolved_drive(*arm.drive);
  }
  section["bends"] = ordered_json::array();
  for (const BendSpecification& bend : swimmer.bends) {
    ordered_json& item = section["bends"].emplace_back();
    item["beads"] = {name(bend.body_A), name(bend.body_B), name(bend.body_C)};
    add_bend(item, bend);
  }
}

}  // namespace

double extent_along_m(const Bead& bead) { return 2.0 * half_extent_m(bead, Eigen::Vector3d::UnitZ()); }

Swimmer read_swimmer(Reader swimmer, double step_s) {
  Swimmer result;
  result.name = swimmer.text("name");
  result.center_m = swimmer.numbers("center_m", 3);
  result.orientation_wxyz = read_frame(swimmer);
  result.phase_deg = read_phase_deg(swimmer);
  if (swimmer.has("arms")) {
    read_general_swimmer(swimmer, step_s, result);
  } else {
    read_three_bead_swimmer(swimmer, result);
  }
  result.published = read_published(swimmer.section("published"));
  return result;
}

ordered_json resolved_swimmer(const Swimmer& swimmer) {
  ordered_json section{{"name", swimmer.name},
                       {"center_m", swimmer.center_m},
                       {"orientation_wxyz", swimmer.orientation_wxyz},
                       {"phase_deg", swimmer.phase_deg}};
  if (swimmer.three_beads)
    add_three_beads(section, swimmer);
  else
    add_beads_and_arms(section, swimmer);
  if (!swimmer.published.empty()) section["published"] = resolved_published(swimmer.published);
  return section;
}

}  // namespace copepod::coupler
