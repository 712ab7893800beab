#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// The swimmer's frame in the world: its quaternion, or the shortest rotation of its z axis to `axis`.
Eigen::Vector4d read_frame(Reader& swimmer) {
  if (!swimmer.has("axis")) return read_orientation(swimmer);
  if (swimmer.has("orientation_wxyz")) {
    swimmer.reject("orientation_wxyz", "is given together with axis (both turn the swimmer). Remove one.");
  }
  return rotation_from_z(read_direction(swimmer, "axis", Eigen::Vector3d::UnitZ()));
}

/// Half of a bead's extent along a unit vector of the swimmer's frame [m]: r + |d·e| L/2.
double half_extent_m(const Bead& bead, const Eigen::Vector3d& direction) {
  const double cosine = std::abs(z_axis(bead.orientation_wxyz).dot(direction));
  const bool across = cosine < 1e-15;  // to rounding
  return bead.shape.radius_m + (across ? 0.0 : 0.5 * cosine * bead.shape.length_m);
}

Bead read_named_bead(Reader bead) {
  Bead result;
  result.name = bead.name("name");
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
      std::string known;
      for (const Bead& bead : swimmer.beads) known += (known.empty() ? "" : ", ") + bead.name;
      reader.reject(
          "beads", "names the bead '" + name + "' (" + swimmer.name + " has none of this name). Known: " + known + ".");
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
  if (!placed && !swimmer.problems().any_under(swimmer.path_of("arms"))) place_chain(swimmer, result, rests);
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

double extent_along_m(const Bead& bead) { return 2.0 * half_extent_m(bead, Eigen::Vector3d::UnitZ()); }

Swimmer read_swimmer(Reader swimmer, double step_s) {
  const Eigen::Vector3d center_m = swimmer.numbers("center_m", 3);
  Swimmer result = read_template(swimmer, step_s);
  result.center_m = center_m;
  return result;
}

Swimmer read_template(Reader& swimmer, double step_s) {
  Swimmer result;
  result.name = swimmer.name("name");
  result.orientation_wxyz = read_frame(swimmer);
  result.phase_deg = read_phase_deg(swimmer);
  if (swimmer.has("arms")) {
    read_general_swimmer(swimmer, step_s, result);
  } else {
    read_three_beads(swimmer, result);
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
