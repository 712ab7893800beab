#include "run/summary.hpp"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <regex>

#include <spdlog/fmt/chrono.h>

#include "config/sections/sections.hpp"
#include "contract/digest.hpp"
#include "system/durable_file.hpp"
#include "system/process.hpp"

namespace copepod::coupler {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

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

/// Now, as "2012-05-03T14:15:16Z".
std::string utc_now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

ordered_json or_null(const std::string& text) { return text.empty() ? ordered_json(nullptr) : ordered_json(text); }

ordered_json or_null(const std::optional<double>& number) {
  return number ? ordered_json(*number) : ordered_json(nullptr);
}

/// Time that a solver worked [s]: all its phases but those in which it waited. For a component that reports
/// none, the time that the coupler waited for it.
double busy_s(const SolverSummary& solver, double waited_s) {
  if (solver.seconds.empty()) return waited_s;
  double sum_s = 0.0;
  for (const auto& [phase, seconds] : solver.seconds) sum_s += solver.waiting_phases.contains(phase) ? 0.0 : seconds;
  return sum_s;
}

/// Part of the loop that a fluid without bodies and without partners would not have needed: messages, waiting
/// for them, and what the fluid does for its bodies. The wait of its ranks for each other's halos is its own.
/// @return null for a fluid that reports no phases
ordered_json coupling_overhead(const SolverSummary& fluid, double loop_s) {
  if (fluid.seconds.empty()) return nullptr;
  double alone_s = 0.0;
  for (const auto& [phase, seconds] : fluid.seconds) alone_s += fluid.body_phases.contains(phase) ? 0.0 : seconds;
  return loop_s > 0.0 ? 1.0 - alone_s / loop_s : 0.0;
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
    throw CaseError(
        directory.string() + " cannot be branched from (" + key + " is " + values.second + ", was " + values.first +
        ": a branch begins with the state of the checkpoint). Change other keys, or start from the beginning.");
  }
  return {directory, step, case_key(before.content), std::move(changed)};
}

Provenance::Provenance(const RunDirectory& directory, const std::string& command_line, const std::string& build,
                       int fluid_ranks, bool resumed)
    : file_(directory.provenance()) {
  const BuildInfo& built = build_info();
  content_ = {{"version", built.version},
              {"git_revision", built.git_revision},
              {"compiler", built.compiler},
              {"build_type", built.build_type},
              {"build", or_null(build)},
              {"host", host_name()},
              {"fluid_ranks", fluid_ranks},
              {"command_line", command_line},
              {"resumed", resumed},
              {"branched_from", nullptr},
              {"components", ordered_json::object()},
              {"notices", ordered_json::array()},
              {"start", utc_now()},
              {"end", nullptr},
              {"status", "running"},
              {"exit_code", nullptr},
              {"earlier_attempts", ordered_json::array()},
              {"exit_reason", nullptr}};
  if (!resumed) return;
  std::ifstream stream(file_);
  ordered_json last = ordered_json::parse(stream, nullptr, false);
  if (!last.is_object()) return;
  for (const char* key : {"branched_from", "earlier_attempts"}) content_[key] = last.value(key, content_[key]);
  last.erase("earlier_attempts");
  content_["earlier_attempts"].push_back(last);
}

void Provenance::set_branch(const Branch& branch, std::int64_t step) {
  ordered_json changed = ordered_json::object();
  for (const auto& [key, values] : branch.changed) changed[key] = {{"was", values.first}, {"is", values.second}};
  content_["branched_from"] = {{"directory", branch.directory.string()}, {"step", step}, {"changed", changed}};
}

void Provenance::write_end(ExitCode code, const std::string& reason) {
  content_["end"] = utc_now();
  content_["status"] = code == ExitCode::finished ? "finished" : "failed";
  content_["exit_code"] = static_cast<int>(code);
  content_["exit_reason"] = or_null(reason);
  write();
}

void Provenance::write() const {
  write_durably(file_, content_.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

std::uint64_t run_digest(const SolverSummary& fluid, const SolverSummary& body, const Kinematics& kinematics) {
  Digest digest;
  digest.add(fluid.digest);
  digest.add(body.digest);
  digest.add(static_cast<std::uint64_t>(kinematics.step));
  digest.add_all(kinematics.position_m);
  digest.add_all(kinematics.orientation_wxyz);
  digest.add_all(kinematics.velocity_m_per_s);
  digest.add_all(kinematics.angular_velocity_rad_per_s);
  return digest.value();
}

ordered_json make_summary(const Case& the_case, std::int64_t steps_done, const SolverSummary& fluid,
                          const SolverSummary& body, const Kinematics& kinematics, const RunTiming& timing,
                          const ordered_json& swimmers) {
  const double own_s = timing.loop_s - timing.fluid_wait_s - timing.body_wait_s;
  ordered_json summary;
  summary["case"] = the_case.name;
  summary["parameter_set"] = or_null(the_case.parameter_set);
  summary["status"] = "finished";
  summary["steps"] = steps_done;
  summary["resumed_from_step"] = timing.first_step > 0 ? ordered_json(timing.first_step) : ordered_json(nullptr);
  summary["step_s"] = the_case.step_s;
  summary["cell_size_m"] =
      the_case.fluid.cell_size_m > 0.0 ? ordered_json(the_case.fluid.cell_size_m) : ordered_json(nullptr);
  summary["wall_s"] = timing.loop_s;
  const std::int64_t computed = steps_done - timing.first_step;  // the solver counts from step 0
  const double share = steps_done > 0 ? static_cast<double>(computed) / static_cast<double>(steps_done) : 0.0;
  summary["mlups"] = timing.loop_s > 0.0 ? share * static_cast<double>(fluid.cell_updates) / timing.loop_s * 1e-6 : 0.0;
  summary["ranks"] = fluid.ranks;
  summary["precision"] = name_of(precision_names, the_case.fluid.precision);
  summary["digest"] = fmt::format("{:016x}", run_digest(fluid, body, kinematics));
  summary["mass_drift"] = or_null(fluid.mass_drift);
  summary["momentum_drift"] = or_null(fluid.momentum_drift);
  summary["timing"] = {{"fluid_s", busy_s(fluid, timing.fluid_wait_s)},
                       {"body_s", busy_s(body, timing.body_wait_s)},
                       {"coupler_s", own_s},
                       {"exchange_wait_s", timing.fluid_wait_s},
                       {"body_wait_s", timing.body_wait_s},
                       {"coupling_overhead", coupling_overhead(fluid, timing.loop_s)}};
  summary["phases_s"] = {{"fluid", fluid.seconds}, {"body", body.seconds}};
  summary.update(swimmers);
  return summary;
}

}  // namespace copepod::coupler
