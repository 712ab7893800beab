#include "component/command_line.hpp"

#include <iostream>
#include <iterator>
#include <sstream>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "contract/errors.hpp"
#include "system/process.hpp"

namespace copepod::component {

namespace {

int print(const std::string& text) {
  std::cout << text << std::endl;
  return static_cast<int>(ExitCode::finished);
}

int fail(const std::string& problem) {
  std::cerr << "error: " << problem << std::endl;
  return static_cast<int>(ExitCode::bad_case);
}

std::string standard_input() { return {std::istreambuf_iterator<char>(std::cin), {}}; }

/// @param ability  what the answer takes
/// @param why_not  where it is missing
template <class Ability, class Answer>
int print_answer(const Ability& ability, const char* why_not, const Answer& answer) {
  if (!ability) return fail(why_not);
  try {
    return print(answer());
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

ParsedCommandLine end_with(std::function<int()> answer) {
  if (launched_rank().value_or(0) != 0) answer = [] { return static_cast<int>(ExitCode::finished); };
  return {std::nullopt, std::move(answer)};
}

/// "%*" in the pattern: the coupling step at the time of the message.
class StepFlag final : public spdlog::custom_flag_formatter {
 public:
  explicit StepFlag(std::shared_ptr<const Vitals> vitals) : vitals_(std::move(vitals)) {}
  void format(const spdlog::details::log_msg&, const std::tm&, spdlog::memory_buf_t& target) override {
    const std::string step = std::to_string(vitals_->step.load());
    target.append(step.data(), step.data() + step.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<StepFlag>(vitals_);
  }

 private:
  std::shared_ptr<const Vitals> vitals_;
};

spdlog::sink_ptr make_sink(const std::string& file) {
  if (file.empty()) return std::make_shared<spdlog::sinks::stderr_sink_mt>();
  try {
    return std::make_shared<spdlog::sinks::basic_file_sink_mt>(file);
  } catch (const spdlog::spdlog_ex& error) {
    throw StorageError("The log file " + file + " cannot be opened (" + error.what() +
                       "). Give --log-file a path that can be written.");
  }
}

}  // namespace

ParsedCommandLine parse_command_line(int argc, char** argv, session::Role role, const Capabilities& capabilities,
                                     const EstimateText& estimate, const BodiesText& bodies) {
  const CLI::Range seconds(0.1, 1e6);
  Options options;
  bool only_capabilities = false, only_estimate = false, only_bodies = false;
  int ranks = 1;
  std::vector<double> units{1.0, 1.0, 1.0};
  CLI::App app{capabilities.name + ", a " + std::string(name_of(role)) + " component of Copepod"};
  app.add_flag("--capabilities", only_capabilities, "Print what this component can do as JSON and exit");
  app.add_flag("--estimate", only_estimate,
               "Read a serialised setup from standard input, print what it takes as JSON and exit");
  app.add_option("--ranks", ranks, "Number of processes that --estimate is for")->check(CLI::PositiveNumber);
  app.add_flag("--bodies", only_bodies, "Read a model (MJCF) from standard input, print its bodies as JSON and exit");
  app.add_option("--units", units, "Length [m], mass [kg] and time [s] that are 1 in the model of --bodies")
      ->expected(3)
      ->check(CLI::PositiveNumber);
  app.add_option("--endpoint", options.endpoint, "Address of the coupler: ipc:///path or tcp://host:port");
  app.add_option("--session", options.session_token, "Token of the run")->envname("COPEPOD_SESSION");
  if (role == session::Role::controller) app.add_option("--name", options.name, "Which controller of the case this is");
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
    std::ostringstream help, mistake;
    const bool asked_for_help = app.exit(error, help, mistake) == 0;
    return end_with([asked_for_help, help = help.str(), mistake = mistake.str()] {
      std::cout << help << std::flush;
      std::cerr << mistake << std::flush;
      return static_cast<int>(asked_for_help ? ExitCode::finished : ExitCode::bad_case);
    });
  }
  if (only_capabilities) {
    const nlohmann::json json = {{"name", capabilities.name},
                                 {"version", capabilities.version},
                                 {"role", name_of(role)},
                                 {"features", capabilities.features}};
    return end_with([text = json.dump()] { return print(text); });
  }
  if (only_estimate)
    return end_with([estimate, ranks] {
      return print_answer(estimate, "this component does not estimate (it does not announce it). Leave --estimate out.",
                          [&] { return estimate(standard_input(), ranks); });
    });
  if (only_bodies)
    return end_with([bodies, units] {
      return print_answer(bodies,
                          "this component reads no models (it does not announce model:mjcf). Leave --bodies out.", [&] {
                            return bodies({standard_input(), units[0], units[1], units[2]});
                          });
    });
  if (options.endpoint.empty() || options.session_token.empty()) {
    return end_with([] {
      return fail(
          "a component needs a coupler to connect to (--endpoint or --session is missing). Give both; deploy/copepod "
          "does so by itself.");
    });
  }
  return {options, {}};
}

std::shared_ptr<spdlog::logger> open_log(const Options& options, session::Role role, int rank,
                                         std::shared_ptr<const Vitals> vitals) {
  auto logger = std::make_shared<spdlog::logger>("copepod", make_sink(options.log_file));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  const std::string who = std::string(name_of(role)) + " rank " + std::to_string(rank);
  formatter->add_flag<StepFlag>('*', std::move(vitals))
      .set_pattern("%Y-%m-%d %H:%M:%S.%e %l [" + who + "] [step %*] %v");
  logger->set_formatter(std::move(formatter));
  logger->set_level(spdlog::level::from_str(options.log_level));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(logger);
  return logger;
}

}  // namespace copepod::component
