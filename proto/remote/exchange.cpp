#include "remote/exchange.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "contract/errors.hpp"
#include "session/handshake.hpp"

namespace copepod::remote {

using session::Health;
using session::Heard;
using session::MessageKind;

namespace {

constexpr std::chrono::milliseconds kSlice{50};  ///< how soon signals and broken connections are noticed

/// The names of lanes are public; a connection that takes one over must hold its role's key.
void require_entitlement(const Party& party, const transport::Frame& frame) {
  if (session::is_entitled(frame.identity, party.session.role)) return;
  throw Refused("A message in the name of the " + std::string(name_of(party.session.role)) +
                " component was refused (its sender holds the key of the " + frame.identity +
                " component). Find out who sent it; the run cannot be trusted.");
}

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
                           " s (it did not start, or got another address)." + note_on_damage() +
                           " Look at its log.");
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
  party.resend_after_s = resend_after_s(patience_, party.request.size(), party.session.attempt);
  party.liveness = on_request(party.liveness, patience_, party.resend_after_s, party.sent_s);
  router_.send(party.data_peer, party.request);
}

void Exchange::attend() {
  throw_if_stopped();
  const double now = now_s();
  for (Party& party : parties_) {
    if (party.is_complete() && !party.is_finished() && ping_is_due(party.liveness, patience_, now))
      ping(party);
  }
  if (router_.receive(frame_, std::min<transport::Duration>(kSlice, time_to_next_ping(now)))) {
    handle(frame_);
    return;
  }
  for (Party& party : parties_) {
    if (party.is_complete() && !party.is_finished()) look_after(party);
  }
}

transport::Duration Exchange::time_to_next_ping(double now_s) const {
  double next_s = 1e300;
  for (const Party& party : parties_) {
    if (party.is_complete() && !party.is_finished()) next_s = std::min(next_s, party.liveness.next_ping_s);
  }
  const double left_s = std::clamp(next_s - now_s, 0.0, 1.0);
  return std::chrono::duration_cast<transport::Duration>(std::chrono::duration<double>(left_s));
}

/// Messages that were damaged on their way count as lost.
void Exchange::handle(const transport::Frame& frame) {
  Party* party = nullptr;
  try {
    if ((party = parties_.by_data_peer(frame.peer)) != nullptr) {
      require_entitlement(*party, frame);
      handle_data(*party, frame);
    } else if ((party = parties_.by_control_peer(frame.peer)) != nullptr) {
      require_entitlement(*party, frame);
      handle_control(*party, frame);
    } else {
      reception_.handle(frame, now_s());
    }
  } catch (const conversion::DamagedMessage&) {
    ++damaged_;
  } catch (const conversion::MalformedMessage& error) {
    throw Refused(party->description() + " breaks the protocol: " + error.what());
  }
}

void Exchange::handle_data(Party& party, const transport::Frame& frame) {
  const MessageKind kind = party.decoder.parse(frame.bytes());
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
  const MessageKind kind = control_decoder_.parse(frame.bytes());
  if (kind == MessageKind::hello) return reception_.handle(frame, now_s());
  const session::Header& header = control_decoder_.header();
  const bool ours = header.session_id == party.session.session_id && header.epoch == party.session.epoch;
  if (kind != MessageKind::pong || !ours) return;
  session::Pong pong;
  control_decoder_.read(pong);
  party.liveness = on_pong(party.liveness, pong, now_s());
  send_again_if_lost(party);
}

void Exchange::ping(Party& party) {
  session::Header header;
  header.session_id = party.session.session_id;
  header.epoch = party.session.epoch;
  party.liveness = on_ping(party.liveness, patience_, now_s());
  router_.send(party.control_peer, control_encoder_.encode(header, session::Ping{stamp_ns()}));
}

void Exchange::look_after(Party& party) {
  const double now = now_s();
  party.liveness = on_look(party.liveness, router_.connected(party.control_peer), patience_, now);
  const Health health = judge(party.liveness, party.session.waits(), patience_, now);
  if (health == Health::fine) return;
  const int rank = health == Health::hung ? party.liveness.pong.awaited_rank : 0;
  const std::string reason = party.description(rank) + " " + describe(health, party.liveness, now) + "." +
                             note_on_damage() +
                             " Look at its log, then run again or resume from a checkpoint.";
  throw ComponentLost(FailureReport{ExitCode::component_lost, std::string(name_of(party.session.role)),
                                    party.hello.host, rank, step_, reason});
}

void Exchange::send_again_if_lost(Party& party) {
  if (!party.session.waits()) return;
  if (!was_lost(party.liveness, party.session.sequence, party.sent_s, party.resend_after_s)) return;
  party.session = ask_again(party.session);
  party.request = party.encoder.encode_again(party.session.attempt);
  party.sent_s = now_s();
  party.resend_after_s = resend_after_s(patience_, party.request.size(), party.session.attempt);
  router_.send(party.data_peer, party.request);
}

std::string Exchange::note_on_damage() const {
  if (damaged_ == 0) return {};
  std::string note = " ";
  note += std::to_string(damaged_) + " message(s) came damaged (their checksum did not fit).";
  return note;
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
