#pragma once

#include <optional>
#include <string>

#include "contract/capabilities.hpp"
#include "session/role.hpp"

namespace copepod::component {

/// What a component is told on its command line; the same for every component.
struct Options {
  std::string endpoint;
  std::string session_token;
  std::string key_file;  ///< CURVE keys of this role; empty: none
  std::string log_file;  ///< empty: standard error
  std::string log_level = "info";
  double orphan_after_s = 10.0;  ///< without a ping of the coupler
  double connect_deadline_s = 60.0;
};

/// Options, or the exit code to end with: after --help and --capabilities, or for a bad command line.
struct ParsedCommandLine {
  std::optional<Options> options;
  int exit_code = 0;
};

/// Reads the command line; prints capabilities, help or an error where that is all there is to do.
ParsedCommandLine parse_command_line(int argc, char** argv, session::Role role,
                                     const Capabilities& capabilities);

/// {"name": …, "version": …, "role": "fluid", "features": […]} in one line.
std::string capabilities_as_json(session::Role role, const Capabilities& capabilities);

}  // namespace copepod::component
