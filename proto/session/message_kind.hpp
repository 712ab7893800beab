#pragma once

#include <array>
#include <string_view>
#include <utility>

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
  kinematics = 30,
  loads = 31,
  applied_loads = 32,
  kinematics_request = 33,
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
inline constexpr std::array kMessageNames = {
    std::pair{MessageKind::none, std::string_view("none")},
    std::pair{MessageKind::hello, std::string_view("Hello")},
    std::pair{MessageKind::welcome, std::string_view("Welcome")},
    std::pair{MessageKind::refusal, std::string_view("Refusal")},
    std::pair{MessageKind::fluid_setup, std::string_view("FluidSetup")},
    std::pair{MessageKind::body_setup, std::string_view("BodySetup")},
    std::pair{MessageKind::configured, std::string_view("Configured")},
    std::pair{MessageKind::kinematics, std::string_view("Kinematics")},
    std::pair{MessageKind::loads, std::string_view("Loads")},
    std::pair{MessageKind::applied_loads, std::string_view("AppliedLoads")},
    std::pair{MessageKind::kinematics_request, std::string_view("KinematicsRequest")},
    std::pair{MessageKind::save, std::string_view("Save")},
    std::pair{MessageKind::saved, std::string_view("Saved")},
    std::pair{MessageKind::restore, std::string_view("Restore")},
    std::pair{MessageKind::restored, std::string_view("Restored")},
    std::pair{MessageKind::summarise, std::string_view("Summarise")},
    std::pair{MessageKind::summary, std::string_view("Summary")},
    std::pair{MessageKind::finish, std::string_view("Finish")},
    std::pair{MessageKind::finished, std::string_view("Finished")},
    std::pair{MessageKind::ping, std::string_view("Ping")},
    std::pair{MessageKind::pong, std::string_view("Pong")},
    std::pair{MessageKind::abort, std::string_view("Abort")},
    std::pair{MessageKind::failure, std::string_view("Failure")},
};

constexpr std::string_view name_of(MessageKind kind) {
  for (const auto& [known, name] : kMessageNames) {
    if (known == kind) return name;
  }
  return "unknown";
}

}  // namespace copepod::session
