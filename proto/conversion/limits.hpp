#pragma once

#include <cstddef>

namespace copepod::conversion {

/// What a message may hold at most. Far above any run, far below what would exhaust a machine.
struct Limits {
  std::size_t message_bytes = std::size_t{256} << 20;
  std::size_t hello_bytes = std::size_t{64} << 10;  ///< before the token has been checked
  std::size_t list_entries = 1'000'000;             ///< of bodies, springs and every other list of a setup
  double cells = 1e12;                              ///< so many times the bytes of a cell are still a 64-bit number
  std::size_t driving_nodes = 16;
  std::size_t string_bytes = 4096;
  std::size_t model_bytes = std::size_t{16} << 20;  ///< text of BodySetup::model
  std::size_t features = 1024;
  std::size_t timers = 1024;
};

inline constexpr Limits kLimits{};

}  // namespace copepod::conversion
