// Fuzz target: a case file; lines that start with "--set " are options of the command line instead.

#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "config/load_case.hpp"
#include "config/problems.hpp"
#include "config/resolved.hpp"
#include "config/yaml_text.hpp"
#include "run/plan.hpp"

namespace {

using namespace copepod::coupler;

constexpr std::string_view kOption = "--set ";

struct Input {
  std::string text;
  std::vector<std::string> overrides;
};

Input split(const std::string& bytes) {
  Input input;
  std::stringstream stream(bytes);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with(kOption))
      input.overrides.push_back(line.substr(kOption.size()));
    else
      input.text += line + '\n';
  }
  return input;
}

/// A case that was accepted has a plan, and its resolved form is accepted again and means the same.
void resolve_twice(const LoadedCase& loaded) {
  static_cast<void>(make_plan(loaded).dump());
  const std::string once = to_yaml(resolved(loaded.content));
  if (to_yaml(resolved(load_case_text(once, "resolved.yaml", {}).content)) != once) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const Input input = split({reinterpret_cast<const char*>(bytes), size});
  LoadedCase loaded;
  try {
    loaded = load_case_text(input.text, "case.yaml", input.overrides);
  } catch (const CaseInvalid& invalid) {
    if (invalid.lines().empty()) std::abort();  // refused without a reason
    return 0;
  }
  resolve_twice(loaded);
  return 0;
}
