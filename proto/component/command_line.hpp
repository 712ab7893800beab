#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <spdlog/logger.h>

#include "component/control_lane.hpp"
#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "session/messages.hpp"

namespace copepod::component {

/// The options of a command line; the same for every component.
struct Options {
  std::string endpoint;
  std::string session_token;
  std::string name;      ///< of a controller in the case
  std::string key_file;  ///< CURVE keys of this role; empty: none
  std::string log_file;  ///< empty: standard error
  std::string log_level = "info";
  double orphan_after_s = 10.0;  ///< without a ping of the coupler
  double connect_deadline_s = 60.0;
};

/// `--estimate`: reads a serialised setup for so many ranks and returns what to print, a line of JSON.
/// @throws Error if the component cannot handle the setup
using EstimateText = std::function<std::string(const std::string& setup_bytes, int ranks)>;

/// `--bodies`: what to print about a model, the bodies that it makes.
/// @throws Error if the component cannot use the model
using BodiesText = std::function<std::string(const ModelSpecification& model)>;

/// Options to serve with; without them `answer` prints what is asked for (--help, --capabilities, --estimate) or what
/// is wrong, and returns the exit code. Under mpirun only the first process prints.
struct ParsedCommandLine {
  std::optional<Options> options;
  std::function<int()> answer;
};

/// Reads the command line and prints nothing yet.
/// @param estimate  empty if the component does not estimate
/// @param bodies    empty if the component reads no models
ParsedCommandLine parse_command_line(int argc, char** argv, session::Role role, const Capabilities& capabilities,
                                     const EstimateText& estimate = {}, const BodiesText& bodies = {});

/// The log of this process: one file, every line with time, level, role, rank and coupling step. It also
/// becomes spdlog's default logger, so that solvers may use spdlog::info and the like.
/// @param vitals  shared, since the logger lives as long as the process
/// @throws StorageError if the file cannot be opened
std::shared_ptr<spdlog::logger> open_log(const Options& options, session::Role role, int rank,
                                         std::shared_ptr<const Vitals> vitals);

}  // namespace copepod::component
