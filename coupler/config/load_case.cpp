#include "config/load_case.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "config/checks/checks.hpp"
#include "config/yaml/document.hpp"
#include "config/yaml/keys.hpp"

namespace copepod::coupler {

namespace {

/// The form of older versions.
void refuse_forces(const Document& document) {
  const Value* forces = document.root().find("forces");
  const bool empty = forces != nullptr && forces->kind == Value::Kind::sequence && forces->items.empty();
  if (forces == nullptr || empty) return;
  throw CaseInvalid(document.locate("forces"),
                    "forces has become actuators (they can follow a body or an arm). Write actuators: [{kind: "
                    "world_force, body: a, direction: [0, 0, 1], signal: {kind: constant, amplitude_N: 1.0e-9}}], or "
                    "signal: {kind: sinusoid, amplitude_N: …, period_steps: …, lag_steps: …}.");
}

LoadedCase read_one(const Document& document) {
  refuse_forces(document);
  Problems problems(document, case_keys);
  LoadedCase loaded;
  loaded.content = read_case(document, problems);
  loaded.assembly = assemble(loaded.content);
  constexpr std::size_t few = 100;  // bodies, for which there is text [docs/decisions/trajectories.md]
  if (TrajectoryFormat& format = loaded.content.output.trajectory_format; format == TrajectoryFormat::by_bodies)
    format = loaded.assembly.bodies.size() > few ? TrajectoryFormat::npy : TrajectoryFormat::csv;
  check_case(loaded.content, loaded.assembly, problems);
  problems.throw_if_any();
  loaded.warnings = problems.warnings();
  return loaded;
}

/// A line of several members of a sweep.
struct LineOfMembers {
  std::string text;
  std::string first_member;
  std::size_t members;
};

void add_line(std::vector<LineOfMembers>& lines, const std::string& text, const std::string& member) {
  const auto found = std::ranges::find(lines, text, &LineOfMembers::text);
  if (found != lines.end())
    ++found->members;
  else
    lines.push_back({text, member, 1});
}

/// Each line with the first of its members, unless all of them have it.
std::vector<std::string> texts_of(const std::vector<LineOfMembers>& lines, std::size_t members) {
  constexpr std::size_t most = 20;
  std::vector<std::string> result;
  for (const LineOfMembers& line : std::span(lines).first(std::min(most, lines.size()))) {
    const std::string others =
        line.members == 1 ? ""
                          : " and " + std::to_string(line.members - 1) + (line.members == 2 ? " other" : " others");
    result.push_back(line.members == members ? line.text
                                             : line.text + " [in member " + line.first_member + others + "]");
  }
  if (lines.size() > most) result.push_back("… and " + std::to_string(lines.size() - most) + " more like these.");
  return result;
}

/// Checks every member of a sweep, so that none fails after hours.
LoadedCase read_members(const Document& document, const Sweep& sweep) {
  std::vector<LineOfMembers> errors, warnings;
  std::optional<LoadedCase> first;
  const std::size_t members = member_count(sweep);
  for (std::size_t member = 0; member < members; ++member) {
    try {
      LoadedCase loaded = read_one(document.with(assignments_of(sweep, member)));
      for (const std::string& line : loaded.warnings) add_line(warnings, line, member_text(sweep, member));
      if (!first) first = std::move(loaded);
    } catch (const CaseInvalid& invalid) {
      for (const std::string& line : invalid.lines()) add_line(errors, line, member_text(sweep, member));
    }
  }
  if (!errors.empty()) throw CaseInvalid(texts_of(errors, members));
  first->warnings = texts_of(warnings, members);
  first->sweep = sweep;
  return std::move(*first);
}

LoadedCase read_document(const Document& document) {
  if (document.root().find("campaign") != nullptr)
    throw CaseInvalid(
        document.locate("campaign"),
        "the file is a campaign (a list of cases). Run it with `copepod campaign`, or name one of its cases.");
  const std::optional<Sweep> sweep = read_sweep(document);
  return sweep ? read_members(document, *sweep) : read_one(document);
}

namespace fs = std::filesystem;

/// What the folder of a campaign holds beside its cases.
constexpr std::array own_folders{"logs", "programs"};

/// The settings of an entry; its keys are those of the case, which the case's own reading checks.
void declare_settings(Keys& keys, std::vector<std::string>& settings) {
  keys.describe("set", {{"type", "object"}, {"additionalProperties", {{"description", "New value."}}}},
                "Changes to the case, by key path (fluid.precision: double), as with --set.");
  const Value* set = keys.mapping("set");
  keys.reject_if(set == nullptr && keys.has("set"), "set",
                 "is not a mapping (it changes keys of the case). Write it as {key.path: value}.");
  if (set == nullptr) return;
  for (const Value::Entry& setting : set->entries)
    settings.push_back(setting.key + "=" + to_json(setting.value).dump());
}

void declare(Keys& keys, CampaignEntry& entry, const fs::path& folder) {
  std::string file;
  keys.text(required("case"), file, "Case file, relative to the folder of the campaign file.");
  entry.case_file = (folder / file).string();
  entry.name = fs::path(file).stem().string();
  keys.name("name", entry.name,
            "Name of the run's folder and of its rows in the tables (default: the file's name). Required if a case "
            "appears twice.");
  declare_settings(keys, entry.settings);
  keys.reject_if(
      std::ranges::find(own_folders, entry.name) != own_folders.end(), "name",
      "is '" + entry.name + "' (the campaign keeps its own files in a folder of this name). Give it another `name`.");
}

void check_names(const std::vector<CampaignEntry>& cases, Problems& problems) {
  std::map<std::string, std::size_t> first;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto [earlier, is_new] = first.emplace(cases[i].name, i);
    if (is_new) continue;
    problems.reject("cases." + std::to_string(i), "is called '" + cases[i].name + "' (so is cases." +
                                                      std::to_string(earlier->second) +
                                                      "). Give it a `name` of its own.");
  }
}

void declare(Keys& keys, Campaign& campaign, const fs::path& folder) {
  keys.name(required("campaign"), campaign.name, "Name of the campaign, for people and for its folder.");
  keys.integer({"jobs", Need::in_some_cases}, campaign.jobs, Range::positive,
               "Cases run at once (default: one per core); the cores are divided among them as ranks of the fluid.");
  keys.list<CampaignEntry>(required("cases"), campaign.cases, "What to run, in this order.",
                           [&](Keys& entry, CampaignEntry& item) { declare(entry, item, folder); });
  keys.describe_also("cases", {{"minItems", 1}});
}

}  // namespace

Campaign load_campaign(const std::string& file, const std::vector<std::string>& overrides) {
  const Document document = Document::load(file, {});
  Problems problems(document);
  Campaign campaign;
  {
    Keys top(&document.root(), "", problems);
    declare(top, campaign, fs::path(file).parent_path());
  }
  if (campaign.cases.empty())
    problems.error("cases", "the campaign has no cases (there is nothing to run). List them below `cases:`.");
  check_names(campaign.cases, problems);
  problems.throw_if_any();
  for (CampaignEntry& entry : campaign.cases)
    entry.settings.insert(entry.settings.end(), overrides.begin(), overrides.end());
  return campaign;
}

LoadedCase load_case(const std::string& file, const std::vector<std::string>& overrides) {
  return read_document(Document::load(file, overrides));
}

LoadedCase load_case_text(const std::string& text, const std::string& source,
                          const std::vector<std::string>& overrides) {
  return read_document(Document::parse(text, source, overrides));
}

bool names_campaign(const std::string& file) {
  if (fs::is_fifo(file)) return false;  // its text comes once only
  return Document::load(file, {}).root().find("campaign") != nullptr;
}

nlohmann::ordered_json campaign_schema() {
  Campaign any;
  return schema_of_file("campaign", "A list of cases that `copepod campaign` runs as one, resuming where it stopped.",
                        [&](Keys& keys) { declare(keys, any, ""); });
}

}  // namespace copepod::coupler
