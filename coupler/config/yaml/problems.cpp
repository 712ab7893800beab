#include "config/yaml/problems.hpp"

#include <algorithm>

#include "config/yaml/document.hpp"

namespace copepod::coupler {
namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

bool at_or_below(const std::string& path, const std::string& top) {
  return path == top || path.starts_with(top + ".");
}

}  // namespace

CaseInvalid::CaseInvalid(std::vector<std::string> lines)
    : CaseError(joined(lines)), lines_(std::move(lines)) {}

CaseInvalid::CaseInvalid(const Origin& origin, const std::string& message)
    : CaseInvalid(std::vector<std::string>{to_string(origin) + ": error: " + message}) {}

void Problems::error(const std::string& path, const std::string& message) {
  error_at(document_.locate(path), path, message);
}

void Problems::error_at(const Origin& origin, const std::string& path, const std::string& message) {
  errors_.push_back({origin, path, to_string(origin) + ": error: " + message});
}

void Problems::warning(const std::string& path, const std::string& message) {
  warnings_.push_back(to_string(document_.locate(path)) + ": warning: " + message);
}

bool Problems::any_under(const std::string& path) const {
  return std::any_of(errors_.begin(), errors_.end(),
                     [&](const Entry& e) { return at_or_below(e.path, path); });
}

void Problems::throw_if_any() const {
  if (errors_.empty()) return;
  std::vector<Entry> sorted = errors_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Entry& a, const Entry& b) { return a.origin.line < b.origin.line; });
  std::vector<std::string> lines;
  for (const Entry& entry : sorted) {
    if (lines.empty() || lines.back() != entry.line) lines.push_back(entry.line);
  }
  throw CaseInvalid(std::move(lines));
}

}  // namespace copepod::coupler
