#include <algorithm>
#include <cctype>
#include <string_view>

#include "config/yaml/keys.hpp"

namespace copepod::coupler {
namespace {

/// Names that people use for one quantity. Ours come first.
const std::vector<std::vector<std::string>> names_of_quantities{
    {"mass", "weight", "density", "rho"},
    {"density", "rho", "mass_density"},
    {"position", "centre", "center", "location", "place", "origin", "pos", "xyz"},
    {"radius", "diameter", "size", "r", "d"},
    {"velocity", "speed", "u", "v"},
    {"angular_velocity", "rotation_rate", "omega", "spin", "angular_speed"},
    {"orientation", "rotation", "quaternion", "attitude"},
    {"stiffness", "spring_constant", "constant", "k"},
    {"damping", "gamma", "dashpot", "viscous_damping"},
    {"step", "dt", "timestep", "time_step", "delta_t"},
    {"relaxation_time", "tau"},
    {"cell_size", "dx", "resolution", "spacing", "grid_spacing", "lattice_spacing", "delta_x"},
    {"domain", "grid", "box", "size", "lattice_size", "domain_size"},
    {"kinematic_viscosity", "viscosity", "nu", "dynamic_viscosity"},
    {"amplitude", "force", "magnitude", "strength", "value"},
    {"period", "frequency"},
    {"lag", "phase", "delay", "phase_lag", "shift"},
    {"steps", "iterations", "timesteps", "time_steps", "duration", "end", "n"},
    {"every", "interval", "output_interval", "write_interval"},
    {"ranks", "processes", "np", "procs", "cores"},
    {"threads", "cores"},
    {"kind", "type"},
    {"shape", "type", "geometry"},
    {"body_force", "force", "acceleration"},
    {"gravity", "g"},
    {"beads", "spheres", "particles"},
    {"bodies", "particles", "spheres", "objects"},
    {"arms", "springs", "links", "legs"},
    {"rest_length", "length", "equilibrium_length"},
    {"seed", "random_seed"},
    {"solver", "method", "engine"},
    {"collision", "collision_model", "collision_operator"},
    {"boundaries", "boundary", "boundary_conditions", "bc", "walls"},
    {"restitution", "elasticity", "bounce"},
    {"friction", "mu", "friction_coefficient"},
    {"name", "id", "label"},
    {"case", "name", "title"},
    {"center", "centre", "position", "location", "origin"},
    {"count", "number", "amount"},
};

/// What stands in front of the unit of a key: "stiffness" of "stiffness_N_per_m".
std::string quantity_of(const std::string& key) {
  static const std::set<std::string_view> units{
      "m",       "m2",     "m3",     "um",      "mm",     "cm",      "nm",    "km",  "kg", "g",     "mg",
      "s",       "ms",     "us",     "ns",      "s2",     "N",       "uN",    "nN",  "pN", "mN",    "J",
      "W",       "Pa",     "kPa",    "rad",     "deg",    "hz",      "Hz",    "per", "lu", "cells", "degrees",
      "radians", "meters", "metres", "seconds", "micron", "microns", "steps", "wxyz"};
  std::string quantity = key;
  for (std::size_t bar = quantity.rfind('_'); bar != std::string::npos; bar = quantity.rfind('_')) {
    if (!units.contains(std::string_view(quantity).substr(bar + 1))) break;
    quantity.resize(bar);
  }
  return quantity;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char letter) { return std::tolower(letter); });
  std::ranges::replace(text, '-', '_');
  return text;
}

/// Small for the same quantity; `far` for another one.
constexpr std::size_t far = 1000;
constexpr std::size_t other_names = 100;  ///< from here on: another name, or a part of the name

std::size_t distance(const std::string& wanted, const std::string& candidate) {
  const std::string quantity = lower(quantity_of(candidate));
  if (wanted == quantity || "number_of_" + wanted == quantity || wanted == "number_of_" + quantity) return 0;
  const std::size_t most_letters = (std::min(wanted.size(), quantity.size()) + 1) / 3;
  const std::size_t letters = edit_distance(wanted, quantity);
  if (letters <= most_letters) return 10 * letters;
  for (const std::vector<std::string>& names : names_of_quantities) {
    const auto place = std::ranges::find(names, wanted);
    if (place != names.end() && names.front() == quantity)
      return other_names + static_cast<std::size_t>(place - names.begin());
  }
  const auto is_part = [](const std::string& part, const std::string& whole) {
    return whole.ends_with("_" + part) || whole.starts_with(part + "_");
  };
  if (is_part(wanted, quantity)) return 200 + quantity.size() - wanted.size();
  if (is_part(quantity, wanted)) return 300 + wanted.size() - quantity.size();
  return far;
}

struct Nearest {
  std::string key;  ///< empty: none is near
  std::size_t distance = far;
  [[nodiscard]] bool differs_in_letters() const { return distance > 0 && distance < other_names; }
};

/// By quantity, then by all letters.
Nearest nearest(const std::string& key, const std::vector<std::string>& known) {
  const std::string wanted = lower(quantity_of(key));
  Nearest best;
  for (const std::string& candidate : known) {
    const std::size_t found = distance(wanted, candidate);
    if (found > best.distance || found == far) continue;
    if (found == best.distance && edit_distance(key, candidate) >= edit_distance(key, best.key)) continue;
    best = {candidate, found};
  }
  return best;
}

/// Sections that have a key of this name; none where they are many.
std::vector<std::string> sections_with(const std::string& key, const std::vector<std::string>& paths) {
  constexpr std::size_t most = 3;
  std::vector<std::string> sections;
  for (const std::string& path : paths) {
    const std::size_t dot = path.rfind('.');
    if (path.substr(dot + 1) != key) continue;
    sections.push_back(dot == std::string::npos ? "the top of the case" : path.substr(0, dot));
  }
  return sections.size() <= most ? sections : std::vector<std::string>();
}

}  // namespace

std::string hint_for(const std::string& key, const std::vector<std::string>& known,
                     const std::vector<std::string>& elsewhere) {
  const Nearest meant = nearest(key, known);
  const std::string question = "Did you mean " + meant.key + "?";
  if (!meant.key.empty() && !meant.differs_in_letters()) return question;
  const std::vector<std::string> sections = sections_with(key, elsewhere);
  if (!sections.empty()) return "It is a key of " + listed(sections) + ".";
  return meant.key.empty() ? "Known here: " + listed(known) + "." : question;
}

}  // namespace copepod::coupler
