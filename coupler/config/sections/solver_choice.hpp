#pragma once

#include "config/yaml/reader.hpp"

namespace copepod::coupler {

/// Reads which solver a section wants: one of `names`, or `{command: …}`, a program of the user's own.
/// @param command  set to the words of that program, left alone otherwise
/// @return E::external for a program of the user's own
template <typename E, std::size_t N>
E read_solver(Reader& section, const std::array<Choice<E>, N>& names, std::optional<E> otherwise,
              std::vector<std::string>& command) {
  const Value* value = section.raw("solver");
  if (value == nullptr || value->kind != Value::Kind::mapping)
    return section.choice("solver", names, otherwise);
  Reader solver = section.section("solver");
  command = solver.command("command");
  if (command.empty() && !solver.problems().any_under(solver.path_of("command"))) {
    solver.problems().error(solver.path_of("command"),
                            solver.path_of("command") +
                                " is missing (a solver is a name, or the command of a component). Write "
                                "{command: \"program argument …\"}.");
  }
  return E::external;
}

}  // namespace copepod::coupler
