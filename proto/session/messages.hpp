#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "contract/capabilities.hpp"
#include "session/role.hpp"
#include "session/version.hpp"

namespace copepod::session {

/// First message of a component on each of its lanes; fields as in handshake.proto.
struct Hello {
  Role role = Role::fluid;
  Lane lane = Lane::data;
  VersionRange versions;
  std::string session_token;
  Capabilities capabilities;
  std::string host;
  std::int64_t pid = 0;
  std::uint32_t ranks = 1;
  std::uint64_t instance = 0;  ///< random, the same on both lanes of a component
};

struct Welcome {
  std::uint32_t minor = 0;
  std::uint64_t session_id = 0;
  std::uint64_t epoch = 0;
};

struct Refusal {
  std::string reason;
};

/// Answer to a setup: the solver exists.
struct Configured {
  std::vector<double> driving_nodes;  ///< bodies only: fractions of a step, ascending, the first 0
};

/// What a component is doing, for messages to the user and to distinguish progress from a standstill.
enum class Phase { connecting, waiting, configuring, exchanging, advancing, checkpointing, finishing };

constexpr std::string_view name_of(Phase phase) {
  constexpr std::array<std::string_view, 7> names = {"connecting", "waiting",       "configuring", "exchanging",
                                                     "advancing",  "checkpointing", "finishing"};
  return names[static_cast<std::size_t>(phase)];
}

struct Ping {
  std::uint64_t stamp_ns = 0;  ///< monotonic clock of the coupler
};

struct Pong {
  std::uint64_t stamp_ns = 0;  ///< of the Ping
  std::int64_t step = -1;
  Phase phase = Phase::connecting;
  std::uint64_t progress = 0;
  std::uint64_t received_sequence = 0;
  std::uint64_t replied_sequence = 0;
  int awaited_rank = 0;  ///< process of the component that the others wait for
};

/// Body of Save and Restore.
struct CheckpointPath {
  std::string path;
};

struct Saved {
  std::string problem;  ///< why nothing was saved; the solver is unchanged; empty: saved
};

}  // namespace copepod::session
