#pragma once

#include <string>
#include <vector>

#include "config/yaml/value.hpp"
#include "contract/errors.hpp"

namespace copepod::coupler {

class Document;

/// The case file is unusable; carries every error found, one line each: "file:line: error: problem (why).
/// What to do."
class CaseInvalid : public CaseError {
 public:
  explicit CaseInvalid(std::vector<std::string> lines);
  CaseInvalid(const Origin& origin, const std::string& message);
  [[nodiscard]] const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

/// Collects what is wrong with a case, so that one look shows every error and not only the first.
/// Places are given as key paths ("swimmers.0.beads.1.radius_m"); the document knows their lines.
class Problems {
 public:
  explicit Problems(const Document& document) : document_(document) {}

  /// @param message  "problem (why). What to do."
  void error(const std::string& path, const std::string& message);
  void error_at(const Origin& origin, const std::string& path, const std::string& message);
  void warning(const std::string& path, const std::string& message);

  /// Whether an error was found at or below `path`; checks that build on a section look here first.
  [[nodiscard]] bool any_under(const std::string& path) const;
  [[nodiscard]] bool any() const { return !errors_.empty(); }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

  /// @throws CaseInvalid if there is any error; lines in the order of the file
  void throw_if_any() const;

 private:
  struct Entry {
    Origin origin;
    std::string path;
    std::string line;
  };
  const Document& document_;
  std::vector<Entry> errors_;
  std::vector<std::string> warnings_;
};

}  // namespace copepod::coupler
