#pragma once

#include <string_view>

namespace copepod::session {

/// Every message of the protocol, in the order of envelope.proto; `none` stands for "no message".
enum class MessageKind {
  none,
  hello,
  welcome,
  refusal,
  fluid_setup,
  body_setup,
  configured,
  kinematics,
  loads,
  applied_loads,
  kinematics_request,
  save,
  saved,
  restore,
  restored,
  summarise,
  summary,
  finish,
  finished,
  ping,
  pong,
  abort,
  failure,
};

/// Name as in the schema.
constexpr std::string_view name_of(MessageKind kind) {
  switch (kind) {
    case MessageKind::none:
      return "none";
    case MessageKind::hello:
      return "Hello";
    case MessageKind::welcome:
      return "Welcome";
    case MessageKind::refusal:
      return "Refusal";
    case MessageKind::fluid_setup:
      return "FluidSetup";
    case MessageKind::body_setup:
      return "BodySetup";
    case MessageKind::configured:
      return "Configured";
    case MessageKind::kinematics:
      return "Kinematics";
    case MessageKind::loads:
      return "Loads";
    case MessageKind::applied_loads:
      return "AppliedLoads";
    case MessageKind::kinematics_request:
      return "KinematicsRequest";
    case MessageKind::save:
      return "Save";
    case MessageKind::saved:
      return "Saved";
    case MessageKind::restore:
      return "Restore";
    case MessageKind::restored:
      return "Restored";
    case MessageKind::summarise:
      return "Summarise";
    case MessageKind::summary:
      return "Summary";
    case MessageKind::finish:
      return "Finish";
    case MessageKind::finished:
      return "Finished";
    case MessageKind::ping:
      return "Ping";
    case MessageKind::pong:
      return "Pong";
    case MessageKind::abort:
      return "Abort";
    case MessageKind::failure:
      return "Failure";
  }
  return "unknown";
}

}  // namespace copepod::session
