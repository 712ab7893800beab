#include "run/provenance.hpp"

#include <array>
#include <chrono>
#include <ctime>
#include <fstream>

#include <nlohmann/json.hpp>

#include "run/build_info.hpp"
#include "system/durable_file.hpp"
#include "system/host_name.hpp"

namespace copepod::coupler {
namespace {

/// Now, as "2012-05-03T14:15:16Z".
std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

/// The provenance that a resumed run finds; not an object if there is none.
nlohmann::ordered_json last_provenance(const RunDirectory& directory) {
  std::ifstream stream(directory.provenance());
  return nlohmann::ordered_json::parse(stream, nullptr, false);
}

/// Added to the attempts which that one found; JSON list.
std::string earlier_attempts(nlohmann::ordered_json last) {
  using nlohmann::ordered_json;
  ordered_json attempts = last.value("earlier_attempts", ordered_json::array());
  last.erase("earlier_attempts");
  attempts.push_back(last);
  return attempts.dump();
}

}  // namespace

Provenance::Provenance(const RunDirectory& directory, std::string command_line, std::string build, int fluid_ranks,
                       bool resumed)
    : directory_(directory),
      command_line_(std::move(command_line)),
      build_(std::move(build)),
      fluid_ranks_(fluid_ranks),
      resumed_(resumed),
      start_(utc_now()),
      earlier_("[]") {
  if (!resumed) return;
  const nlohmann::ordered_json last = last_provenance(directory);
  if (!last.is_object()) return;
  earlier_ = earlier_attempts(last);
  branched_from_ = last.value("branched_from", nlohmann::ordered_json(nullptr)).dump();
}

void Provenance::set_components(const Capabilities& fluid, const Capabilities& body) {
  components_ = {{"fluid", fluid.name + " " + fluid.version}, {"body", body.name + " " + body.version}};
}

void Provenance::set_branch(const Branch& branch, std::int64_t step) {
  using nlohmann::ordered_json;
  ordered_json changed = ordered_json::object();
  for (const auto& [key, values] : branch.changed) changed[key] = {{"was", values.first}, {"is", values.second}};
  branched_from_ = ordered_json{{"directory", branch.directory.string()}, {"step", step}, {"changed", changed}}.dump();
}

void Provenance::write_start() { write("running", -1, "", ""); }

void Provenance::write_end(ExitCode code, const std::string& reason) {
  write(code == ExitCode::finished ? "finished" : "failed", static_cast<int>(code), reason, utc_now());
}

void Provenance::write(const std::string& status, int code, const std::string& reason, const std::string& end) {
  using nlohmann::ordered_json;
  const BuildInfo& build = build_info();
  ordered_json components = ordered_json::object();
  for (const auto& [role, name] : components_) components[role] = name;
  const ordered_json content = {{"version", build.version},
                                {"git_revision", build.git_revision},
                                {"compiler", build.compiler},
                                {"build_type", build.build_type},
                                {"build", build_.empty() ? ordered_json(nullptr) : ordered_json(build_)},
                                {"host", host_name()},
                                {"fluid_ranks", fluid_ranks_},
                                {"command_line", command_line_},
                                {"resumed", resumed_},
                                {"branched_from", ordered_json::parse(branched_from_)},
                                {"components", components},
                                {"notices", notices_},
                                {"start", start_},
                                {"end", end.empty() ? ordered_json(nullptr) : ordered_json(end)},
                                {"status", status},
                                {"exit_code", code < 0 ? ordered_json(nullptr) : ordered_json(code)},
                                {"earlier_attempts", ordered_json::parse(earlier_)},
                                {"exit_reason", reason.empty() ? ordered_json(nullptr) : ordered_json(reason)}};
  write_durably(directory_.provenance(), content.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace copepod::coupler
