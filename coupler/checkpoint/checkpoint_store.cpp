#include "checkpoint/checkpoint_store.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <set>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {

namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* name_start = "step_";
constexpr const char* draft_name = "unfinished";
constexpr std::size_t kept = 2;
constexpr std::array own_names{fluid_file, body_file, "controller.", "coupler.json", "manifest.json"};
constexpr const char* manifest_name = "manifest.json";
constexpr int format_version = 4;

std::set<fs::path> files_below(const fs::path& folder) {
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path relative = fs::relative(entry.path(), folder);
    if (entry.is_regular_file() && relative != manifest_name) files.insert(relative);
  }
  return files;
}

std::string find_damage_of_file(const fs::path& folder, const ordered_json& file) {
  const fs::path path = folder / file.at("path").get<std::string>();
  const auto bytes = whole_number<std::uintmax_t>(file.at("bytes"));
  std::error_code error;
  if (fs::file_size(path, error) != bytes || error) return path.string() + " has the wrong size";
  if (checksum_of_start(path, bytes).value() != whole_number<std::uint64_t>(file.at("checksum")))
    return path.string() + " has changed";
  return {};
}

std::string name_of_step(std::int64_t step) { return fmt::format("{}{:09}", name_start, step); }

/// Step in a checkpoint's name, −1 if it is not the name of one.
std::int64_t step_of_name(const std::string& name) {
  if (!name.starts_with(name_start)) return -1;
  return number_in<std::int64_t>(name.substr(std::string_view(name_start).size())).value_or(-1);
}

/// Removes a folder of a checkpoint, finished or not. @return false, with nothing removed, if it is a link or holds
/// anything else: that is not ours to remove.
bool remove_checkpoint(const fs::path& folder) {
  const auto kind = fs::symlink_status(folder).type();
  if (kind == fs::file_type::not_found) return true;
  if (kind != fs::file_type::directory) return false;
  const auto is_own = [](const fs::directory_entry& entry) {  // perhaps with an ending of its writer's
    const std::string name = entry.path().filename().string();
    return std::ranges::any_of(own_names, [&](const char* own) { return name.starts_with(own); });
  };
  if (!std::ranges::all_of(fs::directory_iterator(folder), is_own)) return false;
  fs::remove_all(folder);
  return true;
}

/// The same where the name is needed. @throws StorageError
void make_way(const fs::path& folder) {
  if (remove_checkpoint(folder)) return;
  throw StorageError(folder.string() + " is in the way of a checkpoint (not written by a run). Move it away.");
}

CouplerState read_state(const fs::path& folder) {
  std::ifstream stream(folder / "coupler.json");
  return coupler_state_from_json(nlohmann::ordered_json::parse(stream, nullptr, false));
}

/// What is wrong with a state beside its checksum: the tables of the run directory are not those that it continues, or
/// it is of another step than its folder.
std::string find_damage(const CouplerState& state, std::int64_t step, const fs::path& run_directory) {
  if (state.step != step) return "its coupler.json is of step " + std::to_string(state.step);
  for (const auto& [name, end] : state.tables) {
    std::string damage = find_damage(run_directory / name, end);
    if (!damage.empty()) return damage;
  }
  return {};
}

}  // namespace

void write_manifest(const fs::path& folder, const std::string& case_key, std::int64_t step) {
  ordered_json files = ordered_json::array();
  for (const fs::path& file : files_below(folder)) {
    const std::uintmax_t bytes = fs::file_size(folder / file);
    const std::uint64_t checksum = checksum_of_start(folder / file, bytes).value();
    files.push_back({{"path", file.string()}, {"bytes", bytes}, {"checksum", checksum}});
  }
  const ordered_json manifest = {{"format", format_version}, {"case", case_key}, {"step", step}, {"files", files}};
  write_durably(folder / manifest_name, manifest.dump(2) + "\n");
}

std::string find_damage(const fs::path& folder, const std::string& case_key) {
  std::ifstream stream(folder / manifest_name);
  if (!stream) return "it has no manifest (writing it was interrupted)";
  try {
    const ordered_json manifest = ordered_json::parse(stream);
    if (manifest.at("format") != format_version) return "another version wrote it";
    if (manifest.at("case") != case_key) return "it belongs to another case";
    std::set<fs::path> unlisted = files_below(folder);
    for (const ordered_json& file : manifest.at("files")) {
      std::string damage = find_damage_of_file(folder, file);
      if (!damage.empty()) return damage;
      unlisted.erase(file.at("path").get<std::string>());
    }
    if (!unlisted.empty()) return "its manifest does not list " + unlisted.begin()->string();
  } catch (const std::exception& error) {
    return std::string("it cannot be read: ") + error.what();
  }
  return {};
}

void CheckpointStore::prepare(const SolversByFile& solvers, const CouplerState& state) {
  const fs::path draft = folder_ / draft_name;
  or_remove_draft([&] {
    make_way(draft);
    fs::create_directories(draft);
    for (const auto& [name, solver] : solvers) solver->save((draft / name).string());
    write_durably(draft / "coupler.json", to_json(state).dump() + "\n");
  });
}

void CheckpointStore::commit(std::int64_t step) {
  const fs::path draft = folder_ / draft_name;
  const fs::path final = folder_ / name_of_step(step);
  or_remove_draft([&] {
    write_manifest(draft, case_key_, step);
    make_way(final);  // one that was damaged and computed again
    publish(draft.string(), final.string());
    keep_two_up_to(step);
  });
}

/// What a full disk left of a checkpoint takes room that the run needs.
void CheckpointStore::or_remove_draft(const std::function<void()>& write) const {
  const auto remove_draft = [&] {
    try {
      remove_checkpoint(folder_ / draft_name);
    } catch (const fs::filesystem_error&) {  // the first error matters
    }
  };
  try {
    write();
  } catch (const StorageError&) {
    remove_draft();
    throw;
  } catch (const fs::filesystem_error& error) {
    remove_draft();
    throw StorageError(std::string("a checkpoint cannot be written (") + error.what() +
                       "). Free space or check permissions.");
  }
}

std::map<std::int64_t, fs::path, std::greater<>> CheckpointStore::newest_first() const {
  std::map<std::int64_t, fs::path, std::greater<>> by_step;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::int64_t step = step_of_name(entry.path().filename().string());
    if (step >= 0) by_step[step] = entry.path();
  }
  return by_step;
}

void CheckpointStore::keep_two_up_to(std::int64_t newest) const {
  std::size_t used = 0;
  for (const auto& [step, folder] : newest_first())
    if (step > newest || (fs::is_directory(folder) && ++used > kept)) remove_checkpoint(folder);
}

FoundCheckpoint CheckpointStore::find(std::optional<std::int64_t> wanted) const {
  FoundCheckpoint found;
  for (const auto& [step, folder] : newest_first()) {
    if (step != wanted.value_or(step)) {
      found.skipped.push_back("there is one of step " + std::to_string(step));
      continue;
    }
    std::string damage = find_damage(folder, case_key_);
    if (damage.empty()) {
      try {
        found.state = read_state(folder);
        found.folder = folder;
        damage = find_damage(found.state, step, folder_.parent_path());
        if (damage.empty()) return found;
      } catch (const StorageError& error) {
        damage = error.what();
      }
    }
    found.skipped.push_back("checkpoint " + folder.string() + " is left out (" + damage + ")");
  }
  const std::string reasons = listed(found.skipped, "; ");
  if (wanted)
    throw StorageError(folder_.string() + " holds no complete checkpoint of step " + std::to_string(*wanted) + " (" +
                       (reasons.empty() ? "there is none" : reasons) + "). Name the step of another one.");
  throw StorageError(folder_.string() + " holds no checkpoint (none is complete" +
                     (reasons.empty() ? "" : "; " + reasons) +
                     "). Start from the beginning, or from a run that has one.");
}

std::uintmax_t CheckpointStore::newest_bytes() const {
  const auto folders = newest_first();
  if (folders.empty()) return 0;
  std::uintmax_t bytes = 0;
  std::error_code error;  // it may be anything of that name
  for (auto entry = fs::recursive_directory_iterator(folders.begin()->second, error);
       entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (entry->is_regular_file(error)) bytes += entry->file_size(error);
  }
  return bytes;
}

std::uintmax_t free_bytes(const fs::path& path) {
  std::error_code error;
  return fs::space(path, error).available;  // UINTMAX_MAX where there is none
}

}  // namespace copepod::coupler
