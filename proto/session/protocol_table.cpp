#include <iostream>
#include <string_view>

#include "session/table_diagram.hpp"
#include "session/table_text.hpp"

/// Prints the transition table: `protocol_table --markdown`, `--mermaid` (a state diagram) or `--json`.
int main(int argc, char** argv) {
  const std::string_view format = argc == 2 ? argv[1] : "";
  if (format == "--markdown") std::cout << copepod::session::table_as_markdown();
  if (format == "--mermaid") std::cout << copepod::session::table_as_mermaid();
  if (format == "--json") std::cout << copepod::session::table_as_json();
  return format == "--markdown" || format == "--mermaid" || format == "--json" ? 0 : 2;
}
