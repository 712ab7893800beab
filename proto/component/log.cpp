#include "component/log.hpp"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "contract/errors.hpp"

namespace copepod::component {

namespace {

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
