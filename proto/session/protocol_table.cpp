#include <iostream>
#include <map>
#include <string>

#include "session/table_diagram.hpp"
#include "session/table_text.hpp"

/// Prints the transition table: `protocol_table --markdown`, `--mermaid` (a state diagram) or `--json`; or
/// the features that components may announce: `--features` or `--features-json`.
int main(int argc, char** argv) {
  using namespace copepod::session;
  const std::map<std::string, std::string (*)()> formats{{"--markdown", table_as_markdown},
                                                         {"--mermaid", table_as_mermaid},
                                                         {"--json", table_as_json},
                                                         {"--features", features_as_markdown},
                                                         {"--features-json", features_as_json}};
  const auto format = formats.find(argc == 2 ? argv[1] : "");
  if (format == formats.end()) return 2;
  std::cout << format->second();
  return 0;
}
