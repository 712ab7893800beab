#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "config/placement/placement.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/keys.hpp"
#include "geometry/rotation.hpp"

// Section `swarm`: a template and how copies of it are placed. They become swimmers like those of section `swimmers`,
// so that nothing else depends on swarms.

namespace copepod::coupler {
namespace {

enum class PlacementKind { random, lattice, file };
enum class Orientations { isotropic, aligned };
enum class Phases { equal, random };

constexpr auto placement_names = words<PlacementKind>("random", "lattice", "file");
constexpr auto orientations_names = words<Orientations>("isotropic", "aligned");
constexpr auto phases_names = words<Phases>("equal", "random");

constexpr std::int64_t most_swimmers = 1'000'000;
constexpr std::size_t most_reported = 10;  // rows of a file

/// The section as it is written.
struct Swarm {
  Swimmer swimmer;
  std::size_t count = 0;  ///< 0: not known yet, or not usable
  std::optional<double> volume_fraction;
  Eigen::Vector3d low_m;  ///< of the region
  Eigen::Vector3d high_m;
  std::array<bool, 3> is_region_given{};
  PlacementKind placement = PlacementKind::random;
  std::optional<CsvRows> rows;
  Orientations orientations = Orientations::isotropic;
  double least_cosine = 1.0;  ///< of the angle to the template's axis
  Phases phases = Phases::equal;
  double gap_m = 0.0;
  std::int64_t seed = 1;
};

void declare_count(Keys& keys, Swarm& swarm) {
  const bool is_file = swarm.placement == PlacementKind::file;
  const bool has_count = keys.has("count"), has_fraction = keys.has("volume_fraction");
  std::int64_t count = 0;
  keys.integer(keys.needed("count", !is_file && !has_fraction), count, Range::positive, "Number of copies.");
  keys.describe_also("count", {{"maximum", most_swimmers}});
  keys.number("volume_fraction", swarm.volume_fraction, Range::positive,
              "Volume of all beads in that of the region, instead of count.");
  keys.reject_if(
      count > most_swimmers, "count",
      "is " + std::to_string(count) + " (at most " + std::to_string(most_swimmers) + " are placed). Use fewer.");
  if (is_file && (has_count || has_fraction))
    keys.reject(has_count ? "count" : "volume_fraction",
                "is given together with a file (which has a row for each swimmer). Remove it.");
  else
    keys.reject_if(has_count && has_fraction, "volume_fraction",
                   "is given together with count (one follows from the other). Remove one.");
  swarm.count = static_cast<std::size_t>(count);
}

/// What is wrong with the limits along an axis; empty: nothing.
std::string problem_with(const Eigen::Vector2d& limits, double length_m) {
  constexpr double rounding = 1e-9;
  if (!(limits[0] < limits[1]))
    return "is empty (it ends at " + length_text(limits[1]) + "). Write [low, high] in metres.";
  if (length_m > 0.0 && (limits[0] < -rounding * length_m || limits[1] > (1.0 + rounding) * length_m))
    return "reaches out of the domain (which is " + length_text(length_m) + " long). Write limits inside it.";
  return "";
}

void declare_limits(Keys& keys, const FluidCase& fluid, Swarm& swarm) {
  const Eigen::Vector3d length_m = fluid.length_m();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char* name = axis_names[axis];
    Eigen::Vector2d limits(0.0, length_m[axis]);
    keys.numbers({name, Need::in_some_cases}, limits, "[low, high] along this axis.");
    swarm.low_m[axis] = limits[0];
    swarm.high_m[axis] = limits[1];
    if (!keys.reads()) continue;
    swarm.is_region_given[axis] = keys.has(name);
    const bool is_known = !keys.has_errors(name);
    if (!swarm.is_region_given[axis] && !(length_m[axis] > 0.0) && !keys.problems().any())
      keys.reject(name, "is missing (the fluid has no domain along it). Write region_m: {x: [0, 1.0e-4], …}.");
    else if (const std::string problem = problem_with(limits, length_m[axis]);
             swarm.is_region_given[axis] && is_known && !problem.empty())
      keys.reject(name, problem);
  }
}

void declare_file_of_places(Keys& keys, Swarm& swarm) {
  keys.describe("file", {{"type", "string"}},
                "For placement: file, a CSV file relative to the case file. Columns x_m,y_m,z_m (centres) and, if "
                "given, axis_x,axis_y,axis_z (directions of the own axes); a row for each copy.");
  const bool is_needed = swarm.placement == PlacementKind::file;
  keys.reject_if(!is_needed && keys.has("file"), "file",
                 "is given without placement: file (it is not read). Remove one.");
  keys.reject_if(
      is_needed && !keys.has("file"), "file",
      "is missing (placement: file takes the places from it). Name a CSV file with the columns x_m,y_m,z_m.");
  if (is_needed && keys.has("file"))
    swarm.rows = read_csv_rows(keys, "file", {"x_m", "y_m", "z_m"}, {"axis_x", "axis_y", "axis_z"});
  if (!swarm.rows) return;
  swarm.count = swarm.rows->values.size();
  keys.reject_if(swarm.rows->has_optional && keys.has("orientations"), "orientations",
                 "is given together with a file that has axes (both turn the swimmers). Remove one.");
}

void declare_orientations(Keys& keys, Swarm& swarm) {
  keys.choice("orientations", swarm.orientations, orientations_names,
              "isotropic: every orientation is as likely; aligned: as the template, with spread_deg.");
  double spread_deg = 0.0;
  keys.number("spread_deg", spread_deg, Range::not_negative,
              "For orientations: aligned, half the angle of the cone about the template's axis in which axes are "
              "evenly spread.");
  keys.describe_also("spread_deg", {{"maximum", 180}});
  // Rounded to single precision, so that every machine has the same number.
  swarm.least_cosine = static_cast<double>(static_cast<float>(std::cos(spread_deg * std::numbers::pi / 180.0)));
  const bool is_isotropic = swarm.orientations == Orientations::isotropic;
  keys.reject_if(is_isotropic && keys.has("spread_deg"), "spread_deg",
                 "is given without orientations: aligned (isotropic axes point everywhere). Remove it.");
  keys.reject_if(!is_isotropic && spread_deg > 180.0, "spread_deg",
                 "is " + rounded_text(spread_deg) + " (angles between axes end at 180). Use less.");
}

void declare(Keys& keys, Swarm& swarm, const Case& the_case) {
  if (keys.reads() && !keys.has("template"))
    keys.reject("template", "is missing (a swarm has copies of it). Write a swimmer below it: name, beads, …");
  else
    keys.section(required("template"), "The swimmer, with the keys of an entry of swimmers but center_m.",
                 [&](Keys& swimmer) {
                   swimmer.reject_if(swimmer.has("center_m"), "center_m",
                                     "is given (the placement gives each swimmer its own). Remove it.");
                   declare(swimmer, swarm.swimmer, the_case.step_s, false);
                 });
  keys.choice("placement", swarm.placement, placement_names,
              "random: anywhere without overlap (random sequential addition); lattice: in the cells of a grid over the "
              "region; file: as the rows of file.");
  declare_count(keys, swarm);
  keys.section("region_m", "Box that holds every bead [m]. Default: the whole domain, across periodic faces too.",
               [&](Keys& region) { declare_limits(region, the_case.fluid, swarm); });
  declare_file_of_places(keys, swarm);
  declare_orientations(keys, swarm);
  keys.choice("phases", swarm.phases, phases_names,
              "Phases of the drives: that of the template (equal), or evenly spread over a period (random).");
  const bool keeps_a_cell = on_lattice(the_case) && swarm.placement != PlacementKind::file;
  swarm.gap_m = keeps_a_cell ? the_case.fluid.cell_size_m : 0.0;
  keys.number({"minimal_gap_m", Need::in_some_cases}, swarm.gap_m, Range::not_negative,
              "Least distance at the start between surfaces of different copies, to other bodies and to walls [m]. "
              "Default: a cell of the lattice; 0 without one, or with a file.");
  keys.integer("seed", swarm.seed, Range::not_negative,
               "Of all that is random; the same seed gives the same swarm on every machine.");
  const auto& planes = the_case.fluid.symmetry_planes;
  keys.reject_if(
      std::ranges::find(planes, true) != planes.end(), "template",
      "cannot be placed in a fluid with symmetry_planes (its copies would lie across them). Remove the planes.");
}

/// Along periodic axes the whole domain has no ends; walls are as far away as other surfaces.
Room room_of(const Swarm& swarm, const Case& the_case) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const FluidCase& fluid = the_case.fluid;
  Room room{swarm.low_m, swarm.high_m, fluid.periodic_length_m(), swarm.gap_m, assemble(the_case).bodies};
  const Eigen::Vector3d length_m = fluid.length_m();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const bool is_periodic = room.periodic_length_m[axis] > 0.0;
    if (is_periodic && !swarm.is_region_given[axis]) {
      room.least_m[axis] = -infinity;
      room.most_m[axis] = infinity;
    }
    const auto is_wall = [&](int face) {
      return fluid.no_slip_plane == face || (!is_periodic && !computes_no_cells(fluid.solver));
    };
    const auto low_face = static_cast<int>(2 * axis);
    if (is_wall(low_face)) room.least_m[axis] = std::max(room.least_m[axis], swarm.gap_m);
    if (is_wall(low_face + 1) && length_m[axis] > 0.0)
      room.most_m[axis] = std::min(room.most_m[axis], length_m[axis] - swarm.gap_m);
  }
  return room;
}

/// Sets the number of swimmers from the volume fraction; reports numbers that cannot fit.
void settle_count(Keys& section, Swarm& swarm) {
  const double region_m3 = (swarm.high_m - swarm.low_m).prod();
  if (swarm.volume_fraction) {
    double swimmer_m3 = 0.0;
    for (const Bead& bead : swarm.swimmer.beads) swimmer_m3 += volume_m3(bead.shape);
    const double count = std::round(*swarm.volume_fraction * region_m3 / swimmer_m3);
    if (!(count >= 1.0 && count <= static_cast<double>(most_swimmers)))
      return section.reject("volume_fraction", "is " + rounded_text(*swarm.volume_fraction) + " (" +
                                                   rounded_text(count) + " swimmers; one to " +
                                                   std::to_string(most_swimmers) +
                                                   " are placed). Use another fraction or region.");
    swarm.count = static_cast<std::size_t>(count);
  }
  double largest_m = 0.0;
  for (const Bead& bead : swarm.swimmer.beads) largest_m = std::max(largest_m, bead.shape.radius_m);
  const double radius_m = largest_m + 0.5 * swarm.gap_m;
  const double taken_m3 = 4.0 / 3.0 * std::numbers::pi * radius_m * radius_m * radius_m;
  const double room_m3 = (swarm.high_m - swarm.low_m + Eigen::Vector3d::Constant(swarm.gap_m)).prod();
  if (swarm.placement == PlacementKind::file || static_cast<double>(swarm.count) * taken_m3 < room_m3) return;
  section.reject(
      section.has("count") ? "count" : "volume_fraction",
      "gives " + std::to_string(swarm.count) +
          " swimmers (not even their largest beads have room in the region). Use fewer, or a larger region.");
}

Eigen::Vector4d draw_orientation(const Swarm& swarm, RandomNumbers& random) {
  if (swarm.orientations == Orientations::isotropic) return random.orientation();
  const Eigen::Vector4d& own = swarm.swimmer.orientation_wxyz;
  if (swarm.least_cosine == 1.0) return own;
  return product(own, rotation_from_z(random.direction_about_z(swarm.least_cosine)));
}

std::vector<Place> place_at_random(Keys& section, const Swarm& swarm, const Placement& placement,
                                   RandomNumbers& random) {
  std::vector<Place> places = placement.fill(swarm.count, [&] {
    Place place;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      place.center_m[axis] = swarm.low_m[axis] + (swarm.high_m[axis] - swarm.low_m[axis]) * random.fraction();
    place.orientation_wxyz = draw_orientation(swarm, random);
    return place;
  });
  if (places.size() < swarm.count) {
    section.reject(section.has("count") ? "count" : "volume_fraction",
                   "gives " + std::to_string(swarm.count) + " swimmers (" + std::to_string(places.size()) +
                       " could be placed at random without overlap). Use fewer, a smaller minimal_gap_m, a larger "
                       "region, or placement: lattice.");
  }
  return places;
}

/// Extents of the template along the world's axes [m]; the diameter about its centre where it is turned in every way.
Eigen::Vector3d extents_m(const Swarm& swarm) {
  const Eigen::Matrix3d R_WS = rotation_matrix(swarm.swimmer.orientation_wxyz);
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  double reach_m = 0.0;
  for (const Bead& bead : swarm.swimmer.beads) {
    const Eigen::Vector3d centre = R_WS * bead.position_m;
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(bounding_radius_m(bead.shape));
    low = low.cwiseMin(centre - half);
    high = high.cwiseMax(centre + half);
    reach_m = std::max(reach_m, centre.norm() + half[0]);
  }
  const bool is_aligned = swarm.orientations == Orientations::aligned && swarm.least_cosine > 0.9;
  return is_aligned ? Eigen::Vector3d(high - low) : Eigen::Vector3d::Constant(2.0 * reach_m);
}

/// "overlap by 2 µm", or "would be 0.5 µm apart, less than minimal_gap_m".
std::string touch_text(double distance_m) {
  return distance_m < 0.0 ? "overlap by " + length_text(-distance_m)
                          : "are " + length_text(distance_m) + " apart, less than minimal_gap_m";
}

std::vector<Place> place_on_lattice(Keys& section, const Swarm& swarm, const Placement& placement,
                                    RandomNumbers& random) {
  std::vector<Place> places;
  for (const Eigen::Vector3d& center_m : lattice_of(swarm.count, swarm.low_m, swarm.high_m, extents_m(swarm)))
    places.push_back({center_m, draw_orientation(swarm, random)});
  const auto report = [&](const std::string& problem) {
    section.reject("placement",
                   "is lattice (" + problem + "). Use fewer swimmers, a larger region, or orientations: aligned.");
  };
  const auto outside = std::ranges::find_if(places, [&](const Place& place) { return !placement.holds(place); });
  const std::vector<Touch> touches = placement.touches(places);
  if (outside != places.end()) {
    report("swimmer " + std::to_string(outside - places.begin() + 1) + " of " + std::to_string(places.size()) +
           " reaches out of the region");
  } else if (!touches.empty()) {
    const std::string other = touches[0].first < 0 ? "another body" : "swimmer " + std::to_string(touches[0].first + 1);
    report(other + " and swimmer " + std::to_string(touches[0].second + 1) + " of " + std::to_string(places.size()) +
           " " + touch_text(touches[0].distance_m));
  }
  return places;
}

std::vector<Place> place_as_in_file(Keys& section, const Swarm& swarm, const Placement& placement,
                                    RandomNumbers& random) {
  const CsvRows& rows = *swarm.rows;
  std::size_t reports = 0;
  const auto report = [&](std::size_t row, const std::string& problem) {
    if (++reports <= most_reported)
      section.problems().error_at({rows.path.string(), rows.lines[row]}, section.path_of("file"), problem);
  };
  std::vector<Place> places;
  for (std::size_t row = 0; row < rows.values.size(); ++row) {
    const std::vector<double>& values = rows.values[row];
    Place& place = places.emplace_back();
    place.center_m = {values[0], values[1], values[2]};
    if (rows.has_optional) {
      const Eigen::Vector3d axis(values[3], values[4], values[5]);
      if (!(axis.norm() > 0.0) || !std::isfinite(axis.norm()))
        report(row, "the axis has no direction (its length is zero or too large). Give a vector.");
      else
        place.orientation_wxyz = rotation_from_z(axis.normalized());
    } else {
      place.orientation_wxyz = draw_orientation(swarm, random);
    }
    if (!placement.holds(place))
      report(row, "the swimmer reaches out of the region (or comes nearer to a wall than minimal_gap_m). Move it.");
  }
  std::pair<int, int> last{-1, -1};
  for (const Touch& touch : placement.touches(places)) {
    if (std::exchange(last, {touch.first, touch.second}) == last) continue;  // other beads of the same two
    const std::string other =
        touch.first < 0 ? "another body" : "that of line " + std::to_string(rows.lines[touch.first]);
    report(touch.second,
           "the swimmer and " + other + " " + touch_text(touch.distance_m) + " (solid bodies need room). Move one.");
  }
  return places;
}

/// Adds the swimmers: around the other swimmers and the bodies, which have been read.
void place(Keys& section, Swarm& swarm, Case& the_case) {
  if (section.problems().any()) return;  // places would follow from wrong numbers
  settle_count(section, swarm);
  if (section.problems().any()) return;
  const std::vector<Bead>& beads = swarm.swimmer.beads;
  const Placement placement({beads.begin(), beads.end()}, room_of(swarm, the_case));
  RandomNumbers random(static_cast<std::uint64_t>(swarm.seed));
  constexpr std::array ways{place_at_random, place_on_lattice, place_as_in_file};
  const std::vector<Place> places = ways[static_cast<std::size_t>(swarm.placement)](section, swarm, placement, random);
  if (section.problems().any()) return;
  RandomNumbers phases(
      ~static_cast<std::uint64_t>(swarm.seed));  // not those of the places, of which trials take more or fewer
  const std::size_t digits = std::to_string(places.size()).size();
  for (std::size_t i = 0; i < places.size(); ++i) {
    Swimmer& swimmer = the_case.swimmers.emplace_back(swarm.swimmer);
    swimmer.name = fmt::format("{}_{:0{}}", swarm.swimmer.name, i + 1, digits);  // swimmer_007 of 100
    swimmer.center_m = places[i].center_m;
    swimmer.orientation_wxyz = places[i].orientation_wxyz;
    if (swarm.phases == Phases::random) swimmer.phase_deg = 360.0 * phases.fraction();
    swimmer.is_of_swarm = true;
  }
}

}  // namespace

void declare_swarm(Keys& keys, Case& the_case) {
  if (!keys.when(keys.has("swarm"))) return;
  Swarm swarm;
  keys.section("swarm",
               "Copies of a swimmer: beside the entries of swimmers and around all other bodies. The resolved case "
               "lists them as swimmers, TEMPLATE_1 to TEMPLATE_N.",
               [&](Keys& section) {
                 declare(section, swarm, the_case);
                 if (section.reads()) place(section, swarm, the_case);
               });
}

}  // namespace copepod::coupler
