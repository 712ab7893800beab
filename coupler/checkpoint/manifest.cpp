#include "checkpoint/manifest.hpp"

#include <fstream>
#include <set>

#include <nlohmann/json.hpp>

#include "checkpoint/whole_number.hpp"
#include "contract/errors.hpp"
#include "storage/checksum.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* manifest_name = "manifest.json";
constexpr int format_version = 3;

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
    if (manifest.at("format") != format_version) return "its format is unknown";
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

}  // namespace copepod::coupler
