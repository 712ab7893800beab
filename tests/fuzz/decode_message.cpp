// Fuzz target: bytes from the wire. Byte 0 is the number of bodies, and of actuators, of the setup, the rest one
// message without its checksum, which is added so that the code behind that check is reached; or with it, for more than
// 250 bodies.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "conversion/codec.hpp"
#include "session/component_session.hpp"
#include "session/coupler_session.hpp"

namespace {

using namespace copepod;
using session::MessageKind;

constexpr Eigen::Index kDrivingNodes = 3;

/// What was accepted once must survive the way back over the wire.
class Echo {
 public:
  template <class Message, class... Shape>
  void operator()(const conversion::Decoder& decoder, Message& message, Shape... shape) {
    decoder.read(message, shape...);
    const auto bytes = encoder_.encode(decoder.header(), message);
    if (again_.parse(bytes) != decoder.kind()) std::abort();
    again_.read(message, shape...);
  }

 private:
  conversion::Encoder encoder_;
  conversion::Decoder again_;
};

/// Arrays are read past Protobuf's parser. A field behind them leaves them to it: it must read the same.
class ProtobufsOpinion {
 public:
  template <class Message, class... Shape>
  void operator()(std::span<const std::byte> message_bytes, const conversion::Decoder& decoder, const Message& message,
                  Shape... shape) {
    const auto content = message_bytes.first(message_bytes.size() - conversion::kChecksumBytes);
    bytes_.assign(content.begin(), content.end());
    for (const int byte : {0x48, 0}) bytes_.push_back(static_cast<std::byte>(byte));  // field 9, unknown
    bytes_.resize(bytes_.size() + conversion::kChecksumBytes);
    conversion::write_checksum(bytes_);
    if (parser_.parse(bytes_) != decoder.kind() || parser_.header() != decoder.header()) std::abort();
    Message opinion;
    parser_.read(opinion, shape...);
    const auto ours = encoder_.encode(decoder.header(), message);
    const auto theirs = other_encoder_.encode(decoder.header(), opinion);
    if (!std::equal(ours.begin(), ours.end(), theirs.begin(), theirs.end())) std::abort();
  }

 private:
  std::vector<std::byte> bytes_;
  conversion::Decoder parser_;
  conversion::Encoder encoder_, other_encoder_;
};

/// The component's state machine meets the message in every state.
void show_to_component(session::Role role, MessageKind kind, const session::Header& header) {
  for (int state = 0; state <= static_cast<int>(session::State::orphaned); ++state) {
    session::ComponentSession component;
    component.role = role;
    component.state = static_cast<session::State>(state);
    component.session_id = header.session_id;
    component.epoch = header.epoch;
    component.last_sequence = header.sequence - 1;
    component.next_step = header.step;
    static_cast<void>(on_message(component, kind, header));
  }
}

/// Every request that the coupler's state machine lets it send, in every state, as the session that waits for
/// its reply.
std::vector<session::CouplerSession> waiting_sessions() {
  std::vector<session::CouplerSession> waiting;
  for (const session::Role role : {session::Role::fluid, session::Role::body, session::Role::controller}) {
    for (int state = 0; state <= static_cast<int>(session::State::orphaned); ++state) {
      for (int request = 0; request <= static_cast<int>(MessageKind::failure); ++request) {
        session::CouplerSession coupler;
        coupler.role = role;
        coupler.state = static_cast<session::State>(state);
        session::Asked asked = ask(coupler, static_cast<MessageKind>(request), 0);
        if (asked.problem.empty()) waiting.push_back(asked.session);
      }
    }
  }
  return waiting;
}

/// The coupler's meets it after each request that it could have sent.
void show_to_coupler(MessageKind kind, const session::Header& header) {
  static const std::vector<session::CouplerSession> waiting = waiting_sessions();
  for (session::CouplerSession coupler : waiting) {
    coupler.session_id = header.session_id;
    coupler.epoch = header.epoch;
    coupler.sequence = header.sequence;
    coupler.step = header.step;
    static_cast<void>(hear(coupler, kind, header));
  }
}

void read(conversion::Decoder& decoder, MessageKind kind, Eigen::Index bodies, std::span<const std::byte> message) {
  static Echo echo;
  static ProtobufsOpinion compare;
  static Kinematics kinematics;
  static Loads loads;
  static AppliedLoads applied;
  static Observation observation;
  const Eigen::Index flow = bodies % 5 == 4 ? 2 : 0;
  switch (kind) {
    case MessageKind::hello: {
      session::Hello hello;
      echo(decoder, hello);
      static_cast<void>(judge_hello(hello, {{}, "token", false}));
      return;
    }
    case MessageKind::welcome: {
      session::Welcome welcome;
      return echo(decoder, welcome);
    }
    case MessageKind::refusal: {
      session::Refusal refusal;
      return echo(decoder, refusal);
    }
    case MessageKind::fluid_setup: {
      FluidSetup setup;
      return echo(decoder, setup);
    }
    case MessageKind::body_setup: {
      BodySetup setup;
      return echo(decoder, setup);
    }
    case MessageKind::controller_setup: {
      ControllerSetup setup;
      return echo(decoder, setup);
    }
    case MessageKind::observation:
      echo(decoder, observation, bodies, flow);
      return compare(message, decoder, observation, bodies, flow);
    case MessageKind::configured: {
      session::Configured configured;
      return echo(decoder, configured);
    }
    case MessageKind::kinematics:
      echo(decoder, kinematics, bodies);
      return compare(message, decoder, kinematics, bodies);
    case MessageKind::loads:
      echo(decoder, loads, bodies, flow);
      return compare(message, decoder, loads, bodies, flow);
    case MessageKind::applied_loads:
      echo(decoder, applied, bodies, bodies, kDrivingNodes);
      return compare(message, decoder, applied, bodies, bodies, kDrivingNodes);
    case MessageKind::save:
    case MessageKind::restore: {
      session::CheckpointPath path;
      return decoder.read(path);
    }
    case MessageKind::summary: {
      SolverSummary summary;
      return echo(decoder, summary);
    }
    case MessageKind::ping: {
      session::Ping ping;
      return echo(decoder, ping);
    }
    case MessageKind::pong: {
      session::Pong pong;
      return echo(decoder, pong);
    }
    case MessageKind::abort: {
      FailureReport report;
      return decoder.read(report);
    }
    case MessageKind::failure: {
      FailureReport report;
      return echo(decoder, report);
    }
    default:
      return;
  }
}

std::span<const std::byte> message_of(std::uint8_t bodies, std::span<const std::byte> content) {
  static std::vector<std::byte> message;
  if (bodies > 250) return content;
  message.assign(content.begin(), content.end());
  message.resize(content.size() + conversion::kChecksumBytes);
  conversion::write_checksum(message);
  return message;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static conversion::Decoder decoder;  // kept between messages, as in the product
  if (size == 0) return 0;
  try {
    const auto message = message_of(bytes[0], std::as_bytes(std::span(bytes + 1, size - 1)));
    const MessageKind kind = decoder.parse(message);
    for (const session::Role role : {session::Role::fluid, session::Role::body, session::Role::controller})
      show_to_component(role, kind, decoder.header());
    show_to_coupler(kind, decoder.header());
    read(decoder, kind, bytes[0], message);
  } catch (const conversion::MalformedMessage&) {
  }
  return 0;
}
