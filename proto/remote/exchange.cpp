#include "remote/exchange.hpp"

#include <chrono>
#include <stdexcept>

#include "contract/errors.hpp"

namespace copepod::remote {

using session::Health;
using session::Heard;
using session::MessageKind;

namespace {

constexpr std::chrono::milliseconds kSlice{50};  ///< how soon signals and broken connections are noticed

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::uint64_t stamp_ns() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

}  // namespace

Exchange::Exchange(transport::Router& router, Parties& parties, const std::string& session_token,
                   const session::Patience& patience, const std::atomic<int>* stop_signal)
    : router_(router),
      parties_(parties),
      reception_(router, parties, session_token),
      patience_(patience),
      stop_signal_(stop_signal) {}

void Exchange::await_components(double deadline_s) {
  const double end_s = now_s() + deadline_s;
  while (!parties_.are_complete()) {
    attend();
    if (now_s() > end_s && !parties_.are_complete()) {
      throw DeadlinePassed("The " + parties_.missing() + " component did not connect within " +
                           std::to_string(static_cast<int>(deadline_s)) +
                           " s (it did not start, or got another address). Look at its log.");
    }
  }
}

Party& Exchange::open_request(session::Role role, MessageKind request, std::int64_t step) {
  Party& party = parties_.of(role);
  const session::Asked asked = session::ask(party.session, request, step);
  if (!asked.problem.empty()) throw std::logic_error(asked.problem);
  party.session = asked.session;
  step_ = step;
  return party;
}

const conversion::Decoder& Exchange::await_reply(Party& party) {
  send_request(party);
  while (party.session.waits()) attend();
  return party.decoder;
}

/// A request that cannot be delivered now is sent again once the component has shown that it misses it.
void Exchange::send_request(Party& party) {
  party.sent_s = now_s();
  party.liveness = on_request(party.liveness, party.sent_s);
  router_.send(party.data_peer, party.request);
}

/// One round of waiting: at most one message, or a look at both components if there is none.
void Exchange::attend() {
  throw_if_stopped();
  for (Party& party : parties_) {
    if (party.is_complete() && !party.is_finished() && ping_is_due(party.liveness, patience_, now_s()))
      ping(party);
  }
  if (router_.receive(frame_, kSlice)) {
    handle(frame_);
    return;
  }
  for (Party& party : parties_) {
    if (party.is_complete() && !party.is_finished()) look_after(party);
  }
}

void Exchange::handle(const transport::Frame& frame) {
  if (Party* party = parties_.by_data_peer(frame.peer)) return handle_data(*party, frame);
  if (Party* party = parties_.by_control_peer(frame.peer)) return handle_control(*party, frame);
  reception_.handle(frame, now_s());
}

void Exchange::handle_data(Party& party, const transport::Frame& frame) {
  MessageKind kind = MessageKind::none;
  try {
    kind = party.decoder.parse(frame.bytes());
  } catch (const conversion::MalformedMessage& error) {
    throw Refused(party.description() + " breaks the protocol: " + error.what());
  }
  if (kind == MessageKind::hello) return reception_.handle(frame, now_s());
  const Heard heard = hear(party.session, kind, party.decoder.header());
  party.session = heard.session;
  if (heard.kind == Heard::Kind::refuse) throw Refused(heard.problem);
  if (heard.kind != Heard::Kind::failure) return;
  FailureReport report;
  party.decoder.read(report);
  throw PeerFailed(report);
}

void Exchange::handle_control(Party& party, const transport::Frame& frame) {
  try {
    const MessageKind kind = control_decoder_.parse(frame.bytes());
    if (kind == MessageKind::hello) return reception_.handle(frame, now_s());
    const session::Header& header = control_decoder_.header();
    const bool ours = header.session_id == party.session.session_id && header.epoch == party.session.epoch;
    if (kind != MessageKind::pong || !ours) return;
    session::Pong pong;
    control_decoder_.read(pong);
    party.liveness = on_pong(party.liveness, pong, now_s());
  } catch (const conversion::MalformedMessage& error) {
    throw Refused(party.description() + " breaks the protocol: " + error.what());
  }
}

void Exchange::ping(Party& party) {
  session::Header header;
  header.session_id = party.session.session_id;
  header.epoch = party.session.epoch;
  party.liveness = on_ping(party.liveness, now_s());
  router_.send(party.control_peer, control_encoder_.encode(header, session::Ping{stamp_ns()}));
}

void Exchange::look_after(Party& party) {
  const double now = now_s();
  party.liveness = on_look(party.liveness, router_.connected(party.control_peer), patience_, now);
  const Health health = judge(party.liveness, party.session.waits(), patience_, now);
  if (health != Health::fine) {
    const std::string reason = party.description() + " " + describe(health, party.liveness, now) +
                               ". Look at its log, then run again or resume from a checkpoint.";
    throw ComponentLost(FailureReport{ExitCode::component_lost, std::string(name_of(party.session.role)),
                                      party.hello.host, 0, step_, reason});
  }
  if (party.session.waits() && was_lost(party.liveness, party.session.sequence, party.sent_s, patience_)) {
    party.session = ask_again(party.session);
    party.request = party.encoder.encode_again(party.session.attempt);
    party.sent_s = now;
    router_.send(party.data_peer, party.request);
  }
}

void Exchange::throw_if_stopped() const {
  const int signal = stop_signal_ == nullptr ? 0 : stop_signal_->load();
  if (signal != 0) throw Interrupted(signal, step_);
}

void Exchange::abort(const FailureReport& report) {
  for (Party& party : parties_) {
    if (party.control_peer.empty() || party.is_finished()) continue;
    session::Header header;
    header.session_id = party.session.session_id;
    header.epoch = party.session.epoch;
    router_.send(party.control_peer, control_encoder_.encode_abort(header, report));
  }
}

}  // namespace copepod::remote
