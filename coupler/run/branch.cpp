#include "run/branch.hpp"

#include <algorithm>

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

bool same_bodies(const std::vector<BodySpecification>& before, const std::vector<BodySpecification>& now) {
  return std::equal(before.begin(), before.end(), now.begin(), now.end(),
                    [](const BodySpecification& a, const BodySpecification& b) {
                      return a.name == b.name && a.motion == b.motion && a.shape.kind == b.shape.kind &&
                             a.shape.radius_m == b.shape.radius_m && a.shape.length_m == b.shape.length_m;
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
  return {directory, step, case_key(before.content), changed_keys(before.content, now.content)};
}

}  // namespace copepod::coupler
