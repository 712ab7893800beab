#include "config/campaign.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include <nlohmann/json.hpp>

#include "config/yaml/document.hpp"

namespace copepod::coupler {
namespace {

namespace fs = std::filesystem;

/// What the folder of a campaign holds beside its cases.
constexpr std::array own_folders{"logs", "programs"};

/// The settings of an entry; its keys are those of the case, which the case's own reading checks.
std::vector<std::string> read_settings(Reader& entry) {
  std::vector<std::string> settings;
  { entry.section("set").accept_all(); }
  const Value* set = entry.raw("set");
  if (set == nullptr) return settings;
  if (set->kind != Value::Kind::mapping) {
    entry.reject("set", "is not a mapping (it changes keys of the case). Write it as {key.path: value}.");
  }
  for (const Value::Entry& setting : set->entries)
    settings.push_back(setting.key + "=" + to_json(setting.value).dump());
  return settings;
}

CampaignEntry read_entry(Reader entry, const fs::path& folder) {
  CampaignEntry result;
  const std::string file = entry.text("case");
  result.case_file = (folder / file).string();
  result.name = entry.name("name", fs::path(file).stem().string());
  result.settings = read_settings(entry);
  if (std::find(own_folders.begin(), own_folders.end(), result.name) != own_folders.end()) {
    entry.reject("name", "is '" + result.name +
                             "' (the campaign keeps its own files in a folder of this name). Give "
                             "it another `name`.");
  }
  return result;
}

void check_names(const std::vector<CampaignEntry>& cases, Problems& problems) {
  std::map<std::string, std::size_t> first;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto [earlier, is_new] = first.emplace(cases[i].name, i);
    if (is_new) continue;
    problems.error("cases." + std::to_string(i), "cases." + std::to_string(i) + " is called '" + cases[i].name +
                                                     "' (so is cases." + std::to_string(earlier->second) +
                                                     "). Give it a `name` of its own.");
  }
}

Campaign read_campaign(Reader top, const fs::path& folder) {
  Campaign result;
  result.name = top.name("campaign");
  result.jobs = top.integer("jobs", Range::positive, 0);
  for (std::size_t i = 0; i < top.size("cases"); ++i) result.cases.push_back(read_entry(top.item("cases", i), folder));
  if (result.cases.empty()) {
    top.problems().error("cases", "the campaign has no cases (there is nothing to run). List them below `cases:`.");
  }
  check_names(result.cases, top.problems());
  return result;
}

Campaign read_document(const Document& document, const std::string& source, AskedKeys* asked) {
  Problems problems(document);
  Campaign campaign = read_campaign(Reader(&document.root(), "", problems, asked), fs::path(source).parent_path());
  problems.throw_if_any();
  return campaign;
}

}  // namespace

bool names_campaign(const std::string& file) {
  if (fs::is_fifo(file)) return false;  // its text comes once only
  return Document::load(file, {}).root().find("campaign") != nullptr;
}

Campaign load_campaign(const std::string& file, const std::vector<std::string>& overrides) {
  Campaign campaign = read_document(Document::load(file, {}), file, nullptr);
  for (CampaignEntry& entry : campaign.cases)
    entry.settings.insert(entry.settings.end(), overrides.begin(), overrides.end());
  return campaign;
}

Campaign load_campaign_text(const std::string& text, const std::string& source, AskedKeys* asked) {
  return read_document(Document::parse(text, source, {}), source, asked);
}

}  // namespace copepod::coupler
