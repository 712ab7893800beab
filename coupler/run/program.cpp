#include "run/program.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <new>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>

#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "config/yaml/keys.hpp"
#include "observers/events.hpp"
#include "run/summary.hpp"
#include "storage/run_directory.hpp"
#include "system/durable_file.hpp"
#include "system/process.hpp"

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

/// Others may connect to the coupler, too, and every connection takes a descriptor.
void raise_limit_of_open_files() {
  constexpr rlim_t enough = 65536;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= enough) return;
  limit.rlim_cur = std::min(limit.rlim_max, enough);
  setrlimit(RLIMIT_NOFILE, &limit);
}

void start_log(const std::string& file) {
  spdlog::sink_ptr sink = std::make_shared<spdlog::sinks::null_sink_mt>();
  try {
    if (!file.empty()) sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file);
  } catch (const spdlog::spdlog_ex& error) {
    throw StorageError(file + " cannot be written (" + error.what() + "). Choose another --log-file.");
  }
  const auto logger = std::make_shared<spdlog::logger>("coupler", sink);
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e %^%l%$ coupler %v");
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(logger);
}

/// Where the run starts that the options ask for, if at a checkpoint of another run.
/// @throws CaseError if the case cannot begin there, or where it is to be resumed
std::optional<Branch> find_branch(const Options& options, const LoadedCase& loaded) {
  if (options.resume && !options.out.empty()) require_same_case(options.out, loaded.content);
  if (options.branch_from.empty()) return std::nullopt;
  return plan_branch(options.branch_from, options.branch_step, loaded);
}

nlohmann::ordered_json plan_of(const Options& options) {
  if (names_campaign(options.case_file)) return make_campaign_plan(load_campaign(options.case_file, options.overrides));
  const LoadedCase loaded = load_case(options.case_file, options.overrides);
  const bool continues = find_branch(options, loaded) || options.resume;
  nlohmann::ordered_json plan = make_plan(loaded, continues ? Beginning::resumed : Beginning::fresh);
  if (options.surfaces) plan["surfaces"] = surfaces_of(loaded);
  return plan;
}

int run_case(const Options& options, std::ostream& out, const MakeComponents& make_components, RunSignals& signals) {
  Events events(out);
  events.phase("starting");
  const LoadedCase loaded = load_case(options.case_file, options.overrides);
  if (loaded.sweep) {
    throw CaseError(options.case_file +
                    " is a sweep (the coupler runs one case). Use deploy/copepod run, or --set sweep=null.");
  }
  const std::optional<Branch> branch = find_branch(options, loaded);
  const RunDirectory directory(options.out);
  start_log(options.log_file);
  for (const std::string& warning : loaded.warnings) spdlog::warn(warning);
  const auto write_case = [&] { write_durably(directory.resolved_case(), to_yaml(resolved(loaded.content))); };
  if (!options.resume) write_case();
  Provenance provenance(directory, options.command_line, options.build, loaded.content.services.fluid_ranks,
                        options.resume);
  provenance.write();

  Options with_recording = options;
  if (loaded.content.output.wire) with_recording.wire_file = directory.new_wire_file();
  const std::unique_ptr<Components> components = make_components(with_recording, loaded.content, signals);
  CaseRun run(loaded, directory, *components, events, signals);
  try {
    const Beginning beginning = options.resume ? Beginning::resumed : branch ? Beginning::branched : Beginning::fresh;
    run.run(beginning, branch, [&](const std::map<std::string, Capabilities>& all, std::int64_t first_step) {
      if (branch) provenance.set_branch(*branch, first_step);
      if (options.resume) write_case();  // it fits the checkpoint
      provenance.set_components(all);
      provenance.write();
    });
    provenance.set_notices(run.notices());
    provenance.write_end(ExitCode::finished, "");
    events.finished(directory.summary().string());
    return static_cast<int>(ExitCode::finished);
  } catch (const std::exception& error) {
    const FailureReport failure = report_of(error, run.step());
    components->abort(failure);
    spdlog::error("{} on {}, rank {}, step {}: {}", failure.component, failure.host, failure.rank, failure.step,
                  failure.reason);
    events.failure(failure);
    provenance.set_notices(run.notices());
    provenance.write_end(failure.code, failure.reason);
    return static_cast<int>(failure.code);
  }
}

}  // namespace

FailureReport report_of(const std::exception& error, std::int64_t step) {
  if (const auto* peer = dynamic_cast<const PeerFailed*>(&error)) return peer->report();
  if (const auto* loss = dynamic_cast<const ComponentLost*>(&error); loss != nullptr && loss->lost())
    return *loss->lost();
  FailureReport report{ExitCode::solver_failed, "coupler", host_name(), 0, step, error.what()};
  if (const auto* ours = dynamic_cast<const Error*>(&error)) {
    report.code = ours->code();
    report.rank = ours->rank();
    if (ours->step() >= 0) report.step = ours->step();
  } else if (dynamic_cast<const std::filesystem::filesystem_error*>(&error) != nullptr) {
    report.code = ExitCode::storage_failed;
    report.reason += " (it was removed or replaced meanwhile?). Look at the run directory.";
  } else if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    report.reason = "memory ran out (the coupler got no more). Use a smaller case, or a machine with more memory.";
  } else {
    report.reason += " (an error that the coupler did not expect). Please report it with the run's logs.";
  }
  return report;
}

Options parse_command_line(int argc, const char* const* argv) {
  CLI::App app{"Copepod coupler: holds the coupling algorithm between a fluid and a body service."};
  Options options;
  std::string plan, run, fluid, body;
  int ranks = 0;
  app.set_version_flag("--version", build_info().version);
  auto* plan_option = app.add_option("--plan", plan, "Check a case or campaign file and print it as JSON");
  app.add_flag("--surfaces", options.surfaces, "With the surfaces of bodies and obstacles")->needs(plan_option);
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

int run_program(int argc, const char* const* argv, std::ostream& out, std::ostream& err,
                const MakeComponents& make_components) {
  try {
    const Options options = parse_command_line(argc, argv);
    if (options.action == Options::Action::plan) out << plan_of(options).dump() << std::endl;
    if (options.action == Options::Action::schema)
      out << (options.schema == "case" ? case_schema() : campaign_schema()).dump(1) << std::endl;
    if (options.action != Options::Action::run) return static_cast<int>(ExitCode::finished);
    raise_limit_of_open_files();
    RunSignals signals;
    const SignalWatch watch(signals);
    return run_case(options, out, make_components, signals);
  } catch (const CaseInvalid& invalid) {
    for (const std::string& line : invalid.lines()) err << printable(line) << '\n';
    err << std::flush;
    return static_cast<int>(ExitCode::bad_case);
  } catch (const Error& error) {
    err << "coupler: error: " << printable(error.what()) << std::endl;
    return static_cast<int>(error.code());
  }
}

}  // namespace copepod::coupler
