#include "run/command_line.hpp"

#include <iostream>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "config/yaml/reader.hpp"
#include "contract/errors.hpp"
#include "run/build_info.hpp"

namespace copepod::coupler {
namespace {

/// JSON is YAML: a list of words that any --set can carry.
std::string as_list(const std::string& command) { return nlohmann::json(split_command(command)).dump(); }

/// All arguments but the session token, which is for the components only.
std::string joined(int argc, const char* const* argv, const std::string& token) {
  std::string line;
  for (int i = 0; i < argc; ++i) {
    const std::string word = argv[i];
    const bool is_secret = !token.empty() && word.ends_with(token);
    line += (i == 0 ? "" : " ") + (is_secret ? word.substr(0, word.size() - token.size()) + "TOKEN" : word);
  }
  return line;
}

void require(const std::string& value, const char* option) {
  if (value.empty()) {
    throw CaseError(std::string("--run needs ") + option +
                    " (the deploy command gives it). Use deploy/copepod run CASE.yaml.");
  }
}

}  // namespace

Options parse_command_line(int argc, const char* const* argv) {
  CLI::App app{"Copepod coupler: holds the coupling algorithm between a fluid and a body service."};
  Options options;
  std::string plan;
  std::string run;
  std::string fluid;
  std::string body;
  int ranks = 0;
  app.set_version_flag("--version", build_info().version);
  auto* plan_option = app.add_option("--plan", plan, "Check a case or campaign file and print it as JSON");
  app.add_option("--run", run, "Run a case file")->excludes(plan_option);
  app.add_option("--schema", options.schema, "Print the JSON schema of case or campaign files")
      ->check(CLI::IsMember({"case", "campaign"}));
  app.add_option("--set", options.overrides, "Replace a value of the case: key.path=value")->expected(1)->take_all();
  app.add_option("--ranks", ranks, "Processes of the fluid service")->check(CLI::PositiveNumber);
  app.add_option("--fluid", fluid, "Command that starts another fluid component");
  app.add_option("--body", body, "Command that starts another body component");
  app.add_option("--out", options.out, "Run directory");
  app.add_option("--endpoint", options.endpoint, "Where the components connect: ipc:///path or tcp://host:port");
  app.add_option("--session", options.session, "Token that the components must show")->envname("COPEPOD_SESSION");
  app.add_option("--keys", options.key_file, "File with the keys of the coupler; required off this machine");
  app.add_option("--log-file", options.log_file, "Log file");
  app.add_option("--build", options.build, "What identifies the programs of this run");
  app.add_flag("--resume", options.resume, "Continue from the newest checkpoint of the run directory");
  app.add_option("--branch-from", options.branch_from, "Start from the newest checkpoint of the run in this directory")
      ->excludes("--resume");
  app.add_option("--branch-step", options.branch_step, "Start from the checkpoint of this step instead")
      ->needs("--branch-from");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    app.exit(success, std::cout, std::cerr);
    return options;
  } catch (const CLI::ParseError& error) {
    throw CaseError(std::string(error.what()) + " (the command line makes no sense). See --help.");
  }
  if (!options.schema.empty()) {
    options.action = Options::Action::schema;
    return options;
  }
  if (plan.empty() && run.empty()) throw CaseError("neither --plan nor --run is given (nothing to do). See --help.");
  options.action = !plan.empty() ? Options::Action::plan : Options::Action::run;
  options.case_file = plan + run;  // one is empty
  options.command_line = joined(argc, argv, options.session);
  if (ranks > 0) options.overrides.push_back("services.fluid.ranks=" + std::to_string(ranks));
  if (!fluid.empty()) options.overrides.push_back("services.fluid.command=" + as_list(fluid));
  if (!body.empty()) options.overrides.push_back("services.body.command=" + as_list(body));
  if (options.action == Options::Action::run) {
    require(options.out, "--out");
    require(options.endpoint, "--endpoint");
    require(options.session, "--session");
  }
  return options;
}

}  // namespace copepod::coupler
