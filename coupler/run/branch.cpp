#include "run/branch.hpp"

#include <algorithm>
#include <regex>
#include <utility>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::json;

std::string dotted(std::string pointer) {
  std::replace(pointer.begin(), pointer.end(), '/', '.');
  return pointer.substr(1);
}

std::string text_of(const json& tree, const json::json_pointer& place) {
  return tree.contains(place) ? tree.at(place).dump() : "none";
}

/// "fluid.cell_size_m is 2e-06, was 1e-06; …", the first few.
std::string described(const ChangedKeys& changed) {
  constexpr std::size_t shown = 4;
  std::string text;
  std::size_t count = 0;
  for (const auto& [key, values] : changed) {
    if (count == shown) return text + "; " + std::to_string(changed.size() - shown) + " more";
    text += (count++ == 0 ? "" : "; ") + key + " is " + values.second + ", was " + values.first;
  }
  return text;
}

LoadedCase case_of_run(const std::filesystem::path& directory) {
  const std::filesystem::path file = directory / "case.yaml";
  if (!std::filesystem::exists(file))
    throw CaseError(directory.string() + " is not a run (it has no case.yaml). Name the directory of a run.");
  return load_case(file.string(), {});
}

bool same_shape(const Shape& a, const Shape& b) {
  const auto same_part = [](const ShapePart& p, const ShapePart& q) {
    return p.position_m == q.position_m && p.orientation_wxyz == q.orientation_wxyz && same_shape(p.shape, q.shape);
  };
  return a.kind == b.kind && a.radius_m == b.radius_m && a.length_m == b.length_m && a.extents_m == b.extents_m &&
         (a.kind != ShapeKind::mesh || *a.mesh == *b.mesh) && std::ranges::equal(a.parts, b.parts, same_part);
}

bool same_bodies(const std::vector<BodySpecification>& before, const std::vector<BodySpecification>& now) {
  return std::equal(before.begin(), before.end(), now.begin(), now.end(),
                    [](const BodySpecification& a, const BodySpecification& b) {
                      return a.name == b.name && a.motion == b.motion && same_shape(a.shape, b.shape);
                    });
}

/// The first reason why a state of one case cannot be one of the other; empty if there is none.
std::string obstacle(const LoadedCase& before, const LoadedCase& now) {
  const FluidCase& a = before.content.fluid;
  const FluidCase& b = now.content.fluid;
  if (a.solver != b.solver || a.kind != b.kind) return "fluid.solver";
  if (a.cell_size_m != b.cell_size_m || a.domain_cells != b.domain_cells) return "the cells";
  if (a.symmetry_planes != b.symmetry_planes) return "fluid.symmetry_planes";
  if (a.precision != b.precision) return "fluid.precision";
  if (before.content.step_s != now.content.step_s) return "the step";
  if (before.content.body.solver != now.content.body.solver) return "body.solver";
  if (before.content.body.integrator != now.content.body.integrator) return "body.integrator";
  if (!same_bodies(before.assembly.bodies, now.assembly.bodies)) return "the bodies or their shapes";
  return {};
}

/// Whether a key, such as `swimmers.0.center_m.2`, is of the state at step 0, which a checkpoint replaces.
bool is_of_the_start(const std::string& key, const std::vector<SingleBody>& bodies) {
  static const std::regex of_swimmers(R"((swimmers\.\d+|swarm)\.(template\.)?(center_m|axis|(beads\.\d+\.)?)"
                                      R"((orientation|orientation_wxyz|position_m))(\..*)?)");
  static const std::regex of_bodies(
      R"(bodies\.(\d+)\.(position_m|orientation_wxyz|velocity_m_per_s|angular_velocity_rad_per_s)(\..*)?)");
  std::smatch found;
  if (std::regex_match(key, found, of_bodies)) {
    const std::size_t body = std::stoul(found[1]);
    return body < bodies.size() && bodies[body].motion != MotionKind::prescribed;
  }
  static const std::regex of_swarms(R"(swarm\.(region_m|orientations|spread_deg|minimal_gap_m)(\..*)?)");
  return std::regex_match(key, of_swimmers) || std::regex_match(key, of_swarms) ||
         key.starts_with("fluid.initial_flow");
}

}  // namespace

ChangedKeys changed_keys(const Case& before, const Case& now) {
  const json old_tree = json::parse(physics_of(before).dump());
  const json new_tree = json::parse(physics_of(now).dump());
  ChangedKeys changed;
  for (const json& difference : json::diff(old_tree, new_tree)) {
    const json::json_pointer place(difference.at("path").get<std::string>());
    changed[dotted(place.to_string())] = {text_of(old_tree, place), text_of(new_tree, place)};
  }
  return changed;
}

void require_same_case(const std::filesystem::path& directory, const Case& now) {
  const ChangedKeys changed = changed_keys(case_of_run(directory).content, now);
  if (changed.empty()) return;
  throw CaseError(directory.string() + " is a run of another case (" + described(changed) +
                  "). Resume it with its own case, or start the changed one with --branch-from " + directory.string() +
                  " in a new folder.");
}

Branch plan_branch(const std::filesystem::path& directory, std::optional<std::int64_t> step, const LoadedCase& now) {
  const LoadedCase before = case_of_run(directory);
  const std::string differs = obstacle(before, now);
  if (!differs.empty()) {
    throw CaseError(directory.string() + " cannot be branched from (" + differs +
                    " would change, and its checkpoints hold a state of the old ones). Change other keys, or start "
                    "from the beginning.");
  }
  ChangedKeys changed = changed_keys(before.content, now.content);
  for (const auto& [key, values] : changed) {
    if (!is_of_the_start(key, now.content.bodies)) continue;
    throw CaseError(directory.string() + " cannot be branched from (" + key + " is " + values.second + ", was " +
                    values.first +
                    ": a branch begins with the state of the checkpoint). Change other keys, or start "
                    "from the beginning.");
  }
  return {directory, step, case_key(before.content), std::move(changed)};
}

}  // namespace copepod::coupler
