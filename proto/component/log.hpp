#pragma once

#include <memory>

#include <spdlog/logger.h>

#include "component/command_line.hpp"
#include "component/vitals.hpp"

namespace copepod::component {

/// The log of this process: one file, every line with time, level, role, rank and coupling step. It also
/// becomes spdlog's default logger, so that solvers may use spdlog::info and the like.
/// @param vitals  shared, since the logger lives as long as the process
/// @throws StorageError if the file cannot be opened
std::shared_ptr<spdlog::logger> open_log(const Options& options, session::Role role, int rank,
                                         std::shared_ptr<const Vitals> vitals);

}  // namespace copepod::component
