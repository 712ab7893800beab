#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include <spdlog/logger.h>

#include "component/vitals.hpp"
#include "contract/errors.hpp"

namespace copepod::fluid {

/// Log of a rank that the coupler does not talk to: `<log file of rank 0>.rank<N>`, or standard error.
class FollowerLog {
 public:
  /// Reads --log-file and --log-level; everything else on the command line is rank 0's business.
  FollowerLog(int argc, char** argv, int rank);

  /// Shown in every line from now on.
  [[nodiscard]] std::atomic<std::int64_t>& current_step() const { return vitals_->step; }

  void finished() const;
  void failed(const Error& error) const;

 private:
  std::shared_ptr<component::Vitals> vitals_;
  std::shared_ptr<spdlog::logger> log_;
};

}  // namespace copepod::fluid
