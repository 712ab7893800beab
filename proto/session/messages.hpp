#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "contract/capabilities.hpp"

namespace copepod::session {

/// Every message of the protocol, with the number of its field in envelope.proto; `none` stands for "no message".
enum class MessageKind {
  none = 0,
  hello = 10,
  welcome = 11,
  refusal = 12,
  fluid_setup = 20,
  body_setup = 21,
  configured = 22,
  controller_setup = 23,
  kinematics = 30,
  loads = 31,
  applied_loads = 32,
  kinematics_request = 33,
  observation = 34,
  action = 35,
  save = 40,
  saved = 41,
  restore = 42,
  restored = 43,
  summarise = 50,
  summary = 51,
  finish = 52,
  finished = 53,
  ping = 60,
  pong = 61,
  abort = 62,
  failure = 63,
};

/// Names as in the schema.
inline constexpr auto kMessageNames = [] {
  using enum MessageKind;
  return std::to_array<std::pair<MessageKind, std::string_view>>({
      {none, "none"},
      {hello, "Hello"},
      {welcome, "Welcome"},
      {refusal, "Refusal"},
      {fluid_setup, "FluidSetup"},
      {body_setup, "BodySetup"},
      {configured, "Configured"},
      {controller_setup, "ControllerSetup"},
      {kinematics, "Kinematics"},
      {loads, "Loads"},
      {applied_loads, "AppliedLoads"},
      {kinematics_request, "KinematicsRequest"},
      {observation, "Observation"},
      {action, "Action"},
      {save, "Save"},
      {saved, "Saved"},
      {restore, "Restore"},
      {restored, "Restored"},
      {summarise, "Summarise"},
      {summary, "Summary"},
      {finish, "Finish"},
      {finished, "Finished"},
      {ping, "Ping"},
      {pong, "Pong"},
      {abort, "Abort"},
      {failure, "Failure"},
  });
}();

constexpr std::string_view name_of(MessageKind kind) {
  for (const auto& [known, name] : kMessageNames)
    if (known == kind) return name;
  return "unknown";
}

/// Protocol version of this build. Minor versions only add fields and messages.
inline constexpr std::uint32_t kProtocolMajor = 2;
inline constexpr std::uint32_t kProtocolMinor = 0;

/// Everything of an Envelope but its body; the fields are documented in envelope.proto.
struct Header {
  std::uint32_t protocol_major = kProtocolMajor;
  std::uint32_t protocol_minor = kProtocolMinor;
  std::uint64_t session_id = 0;
  std::uint64_t epoch = 0;
  std::uint64_t sequence = 0;
  std::uint32_t attempt = 0;
  std::int64_t step = -1;

  /// The same for a message about another step.
  [[nodiscard]] Header at(std::int64_t other_step) const {
    Header header = *this;
    header.step = other_step;
    return header;
  }

  bool operator==(const Header&) const = default;
};

/// What a component is to the coupler; a run has one fluid, one body, and the controllers of its case.
enum class Role { fluid, body, controller };

/// Which of a component's two sockets a message travels on.
enum class Lane { data, control };

constexpr std::string_view name_of(Role role) {
  return role == Role::fluid ? "fluid" : role == Role::body ? "body" : "controller";
}
constexpr std::string_view name_of(Lane lane) { return lane == Lane::data ? "data" : "control"; }

/// Protocol versions of one side.
struct VersionRange {
  std::uint32_t major = kProtocolMajor;
  std::uint32_t minor_min = 0;
  std::uint32_t minor_max = kProtocolMinor;

  bool operator==(const VersionRange&) const = default;
};

/// Newest minor version of both sides; nothing if there is none.
constexpr std::optional<std::uint32_t> negotiate(const VersionRange& ours, const VersionRange& theirs) {
  if (ours.major != theirs.major) return std::nullopt;
  const std::uint32_t newest = std::min(ours.minor_max, theirs.minor_max);
  const std::uint32_t oldest = std::max(ours.minor_min, theirs.minor_min);
  if (newest < oldest) return std::nullopt;
  return newest;
}

/// "1.0 to 1.3"
inline std::string to_text(const VersionRange& range) {
  const std::string major = std::to_string(range.major) + ".";
  return major + std::to_string(range.minor_min) + " to " + major + std::to_string(range.minor_max);
}

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
  std::string name;            ///< of a controller: which one of the case

  /// What the component is called in messages and files: "fluid", "body", or the controller's name.
  [[nodiscard]] std::string party() const { return role == Role::controller ? name : std::string(name_of(role)); }
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
