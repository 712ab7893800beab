#include "service/follower_log.hpp"

#include <iostream>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <spdlog/sinks/null_sink.h>

#include "component/log.hpp"

namespace copepod::fluid {

namespace {

component::Options log_options(int argc, char** argv, int rank) {
  component::Options options;
  CLI::App app;
  app.allow_extras();
  app.set_help_flag();
  app.add_option("--log-file", options.log_file);
  app.add_option("--log-level", options.log_level);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError&) {
    return {};  // rank 0 complains about it
  }
  if (options.log_file.empty()) {
    options.log_level = "warning";  // only rank 0 writes to the terminal
  } else {
    options.log_file += ".rank" + std::to_string(rank);
  }
  return options;
}

/// A log that cannot be opened must not leave the other ranks waiting.
std::shared_ptr<spdlog::logger> open_or_do_without(const component::Options& options, int rank,
                                                   const std::shared_ptr<component::Vitals>& vitals) {
  try {
    return component::open_log(options, session::Role::fluid, rank, vitals);
  } catch (const StorageError& error) {
    std::cerr << "warning: " << error.what() << std::endl;
    return std::make_shared<spdlog::logger>("silent", std::make_shared<spdlog::sinks::null_sink_mt>());
  }
}

}  // namespace

FollowerLog::FollowerLog(int argc, char** argv, int rank)
    : vitals_(std::make_shared<component::Vitals>()),
      log_(open_or_do_without(log_options(argc, argv, rank), rank, vitals_)) {
  log_->info("Rank {} of the fluid, pid {}.", rank, getpid());
}

void FollowerLog::finished() const { log_->info("Finished."); }

void FollowerLog::failed(const Error& error) const {
  log_->error("Rank {} failed at step {}: {}", error.rank(), error.step(), error.what());
}

}  // namespace copepod::fluid
