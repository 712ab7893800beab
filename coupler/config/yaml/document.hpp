#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/yaml/value.hpp"

namespace copepod::coupler {

/// The case as written, after parameter set and command line had their say; knows the line of every key path.
///
/// A key path joins keys and list positions with dots: "swimmers.0.spring.stiffness_N_per_m". Where a list
/// holds mappings with a `name`, the name may stand for the position.
class Document {
 public:
  /// Reads `file`, applies the chosen parameter set, then `overrides` ("key.path=value", value in YAML).
  /// @throws CaseInvalid if the file cannot be read, is no YAML mapping, or an override has no place to go
  static Document load(const std::string& file, const std::vector<std::string>& overrides);

  /// The same from text; `source` names it in messages.
  static Document parse(const std::string& text, const std::string& source,
                        const std::vector<std::string>& overrides);

  [[nodiscard]] const Value& root() const { return root_; }

  /// Where `path` was written; for a path that is not there, where the nearest section around it was.
  [[nodiscard]] Origin locate(const std::string& path) const;

 private:
  explicit Document(Value root) : root_(std::move(root)) {}
  void apply_parameter_set(bool chosen_on_command_line);
  void assign(const std::string& path, Value value);

  Value root_;
};

}  // namespace copepod::coupler
