#include "component/command_line.hpp"

#include <iostream>
#include <iterator>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "contract/exit_code.hpp"

namespace copepod::component {

std::string capabilities_as_json(session::Role role, const Capabilities& capabilities) {
  const nlohmann::json json = {{"name", capabilities.name},
                               {"version", capabilities.version},
                               {"role", std::string(name_of(role))},
                               {"features", capabilities.features}};
  return json.dump();
}

namespace {

ParsedCommandLine end_with(ExitCode code) { return {std::nullopt, static_cast<int>(code)}; }

ParsedCommandLine fail(const std::string& problem) {
  std::cerr << "error: " << problem << std::endl;
  return end_with(ExitCode::bad_case);
}

ParsedCommandLine print_estimate(const EstimateText& estimate, int ranks) {
  if (!estimate) return fail("this component does not estimate (it does not announce it). Leave --estimate out.");
  const std::string setup{std::istreambuf_iterator<char>(std::cin), {}};
  try {
    std::cout << estimate(setup, ranks) << std::endl;
    return end_with(ExitCode::finished);
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

}  // namespace

ParsedCommandLine parse_command_line(int argc, char** argv, session::Role role, const Capabilities& capabilities,
                                     const EstimateText& estimate) {
  const CLI::Range seconds(0.1, 1e6);
  Options options;
  bool only_capabilities = false, only_estimate = false;
  int ranks = 1;
  CLI::App app{capabilities.name + ", a " + std::string(name_of(role)) + " component of Copepod"};
  app.add_flag("--capabilities", only_capabilities, "Print what this component can do as JSON and exit");
  app.add_flag("--estimate", only_estimate,
               "Read a serialised setup from standard input, print what it takes as JSON and exit");
  app.add_option("--ranks", ranks, "Number of processes that --estimate is for")->check(CLI::PositiveNumber);
  app.add_option("--endpoint", options.endpoint, "Address of the coupler: ipc:///path or tcp://host:port");
  app.add_option("--session", options.session_token, "Token of the run")->envname("COPEPOD_SESSION");
  app.add_option("--keys", options.key_file, "File with the keys of this role; required off this machine");
  app.add_option("--log-file", options.log_file, "Where to log; standard error if not given");
  app.add_option("--log-level", options.log_level, "How much to log")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "off"}));
  app.add_option("--orphan-after", options.orphan_after_s, "End after so many seconds without the coupler")
      ->check(seconds);
  app.add_option("--connect-deadline", options.connect_deadline_s, "Wait so many seconds for the coupler")
      ->check(seconds);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked_for_help = app.exit(error) == 0;
    return end_with(asked_for_help ? ExitCode::finished : ExitCode::bad_case);
  }
  if (only_capabilities) {
    std::cout << capabilities_as_json(role, capabilities) << std::endl;
    return end_with(ExitCode::finished);
  }
  if (only_estimate) return print_estimate(estimate, ranks);
  if (options.endpoint.empty() || options.session_token.empty()) {
    return fail(
        "a component needs a coupler to connect to (--endpoint or --session is missing). Give both; "
        "deploy/copepod does so by itself.");
  }
  return {options, 0};
}

}  // namespace copepod::component
