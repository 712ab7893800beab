// Fuzz target: a case file; lines that start with "--set " are options of the command line instead.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "config/load_case.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "run/program.hpp"

namespace {

using namespace copepod::coupler;

constexpr std::string_view kOption = "--set ";

struct Input {
  std::string text;
  std::vector<std::string> overrides;
};

Input split(std::string_view bytes) {
  Input input;
  while (!bytes.empty()) {
    const std::string_view line = bytes.substr(0, bytes.find('\n'));
    if (line.starts_with(kOption))
      input.overrides.emplace_back(line.substr(kOption.size()));
    else
      input.text.append(line).append(1, '\n');
    bytes.remove_prefix(std::min(line.size() + 1, bytes.size()));
  }
  return input;
}

/// A case that was accepted has a plan, and its resolved form is accepted again and means the same.
void resolve_twice(const LoadedCase& loaded) {
  static_cast<void>(make_plan(loaded, Beginning::fresh).dump());
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
