#include "remote/link.hpp"

#include <bit>
#include <chrono>
#include <future>
#include <stdexcept>

#include <spdlog/spdlog.h>

#include "contract/words.hpp"
#include "recording/recorder.hpp"

namespace copepod::coupler {
using session::Health;
using session::Heard;
using session::Hello;
using session::Lane;
using session::MessageKind;

namespace {

constexpr std::chrono::milliseconds kSlice{50};   ///< how soon signals and broken connections are noticed
constexpr std::chrono::milliseconds kMoment{20};  ///< most work beside the link is over by then

session::Patience patience_of(const LinkSettings& settings) {
  session::Patience patience;
  patience.silence_s = settings.silence_s;
  patience.disconnected_s = std::max(patience.disconnected_s, 0.1 * settings.silence_s);
  patience.progress_deadline_s = settings.progress_deadline_s;
  return patience;
}

std::unique_ptr<transport::Router> make_router(const LinkSettings& settings) {
  std::optional<transport::CouplerKeys> keys;
  if (!settings.key_file.empty()) keys = transport::read_coupler_keys(settings.key_file);
  auto router = transport::bind_router(settings.endpoint, keys);
  if (settings.wire_file.empty()) return router;
  return std::make_unique<recording::RecordingRouter>(std::move(router), settings.wire_file);
}

/// The names of lanes are not secret; a sender that uses one must hold the key of its role.
void require_entitlement(const Party& party, const transport::Frame& frame) {
  if (session::is_entitled(frame.identity, party.name)) return;
  throw Refused("A message in the name of the " + party.name +
                " component was refused (its sender holds the key of the " + frame.identity +
                " component). Find out who sent it; the run cannot be trusted.");
}

/// Of a message beside the requests.
session::Header sessions_header(const Party& party) {
  return {.session_id = party.session.session_id, .epoch = party.session.epoch};
}

std::uint64_t stamp_ns() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

/// Grows from one coupler to the next on a machine.
std::uint64_t microseconds_since_1970() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

std::optional<Hello> read_hello(conversion::Decoder& decoder, const transport::Frame& frame) {
  if (frame.bytes().size() > conversion::kLimits.hello_bytes) return std::nullopt;
  try {
    if (decoder.parse(frame.bytes()) != MessageKind::hello) return std::nullopt;
    Hello hello;
    decoder.read(hello);
    return hello;
  } catch (const conversion::MalformedMessage&) {
    return std::nullopt;
  }
}

}  // namespace

Link::Link(const LinkSettings& settings) : Link(settings, make_router(settings)) {}

Link::Link(const LinkSettings& settings, std::unique_ptr<transport::Router> router)
    : connect_deadline_s_(settings.connect_deadline_s),
      patience_(patience_of(settings)),
      stop_signal_(settings.stop_signal),
      router_(std::move(router)),
      parties_(settings.controllers),
      handshake_(*router_, parties_, settings.session) {}

void Link::await_components() {
  const double end_s = now_s() + connect_deadline_s_;
  while (!parties_.are_complete()) {
    attend(kSlice);
    if (now_s() > end_s && !parties_.are_complete()) {
      throw DeadlinePassed("The " + parties_.missing() + " component did not connect within " +
                           std::to_string(static_cast<int>(connect_deadline_s_)) +
                           " s (it did not start, or got another address)." + note_on_damage() + " Look at its log.");
    }
  }
}

void Link::stay_in_touch_during(const std::function<void()>& work) {
  std::future<void> done = std::async(std::launch::async, work);
  do {
    while (attend(transport::Duration::zero())) {
    }
  } while (done.wait_for(kMoment) != std::future_status::ready);
  done.get();
}

void Link::finish() {
  for (std::size_t number = 0; number < parties_.size(); ++number) {
    const auto encode = [](conversion::Encoder& encoder, const session::Header& header) {
      return encoder.encode(header, MessageKind::finish);
    };
    ask(number, MessageKind::finish, parties_[number].session.step, encode, [](const conversion::Decoder&) {});
  }
}

void Link::abort(const FailureReport& report) noexcept {
  try {
    for (Party& party : parties_) {
      if (party.control_peer.empty() || party.is_finished()) continue;
      router_->send(party.control_peer, control_encoder_.encode_abort(sessions_header(party), report));
    }
  } catch (...) {  // the run is over already; components notice by themselves that the coupler is gone
  }
}

Party& Link::open_request(std::size_t number, MessageKind request, std::int64_t step) {
  Party& party = parties_[number];
  if (party.ended) throw PeerFailed(*party.ended);
  const session::Asked asked = session::ask(party.session, request, step);
  if (!asked.problem.empty()) throw std::logic_error(asked.problem);
  party.session = asked.session;
  step_ = step;
  return party;
}

void Link::await_reply(Party& party) {
  send_request(party);
  party.liveness = on_request(party.liveness, patience_, party.resend_after_s, party.sent_s);
  while (party.session.waits()) attend(kSlice);
}

/// A request that cannot be delivered now is sent again once the component has shown that it misses it.
void Link::send_request(Party& party) {
  party.sent_s = now_s();
  party.resend_after_s = resend_after_s(patience_, party.request.size(), party.session.attempt);
  router_->send(party.data_peer, party.request);
}

/// One round of waiting: at most one message, or a look at all components if there is none. @return whether one came
bool Link::attend(transport::Duration longest) {
  throw_if_stopped();
  const double now = now_s();
  for (Party& party : parties_) {
    if (party.is_complete() && !party.is_finished() && ping_is_due(party.liveness, patience_, now)) ping(party);
  }
  if (router_->receive(frame_, std::min(longest, time_to_next_ping(now)))) {
    handle(frame_);
    return true;
  }
  for (std::string text = router_->next_remark(); !text.empty(); text = router_->next_remark()) log_remark(text);
  for (Party& party : parties_) {
    if (party.is_complete() && !party.is_finished()) look_after(party);
  }
  return false;
}

transport::Duration Link::time_to_next_ping(double now_s) const {
  double next_s = 1e300;
  for (const Party& party : parties_) {
    if (party.is_complete() && !party.is_finished()) next_s = std::min(next_s, party.liveness.next_ping_s);
  }
  const double left_s = std::clamp(next_s - now_s, 0.0, 1.0);
  return std::chrono::duration_cast<transport::Duration>(std::chrono::duration<double>(left_s));
}

/// Messages that were damaged on their way count as lost.
void Link::handle(const transport::Frame& frame) {
  Party* party = nullptr;
  try {
    if ((party = parties_.by_peer(frame.peer, &Party::data_peer)) != nullptr) {
      require_entitlement(*party, frame);
      handle_data(*party, frame);
    } else if ((party = parties_.by_peer(frame.peer, &Party::control_peer)) != nullptr) {
      require_entitlement(*party, frame);
      handle_control(*party, frame);
    } else {
      shake_hands(frame);
    }
  } catch (const conversion::DamagedMessage&) {
    ++damaged_;
  } catch (const conversion::MalformedMessage& error) {
    if (party == nullptr) throw;
    party->ended = violation(*party, party->session.current_step(), error).report();
    throw PeerFailed(*party->ended);
  }
}

/// Strangers may come in any number: from some on only a few of them are mentioned.
void Link::log_remark(const std::string& text) {
  constexpr std::uint64_t all_of_them = 16;
  if (++remarks_ > all_of_them && !std::has_single_bit(remarks_)) return;
  spdlog::warn("{} [{}]", printable(text), remarks_);
}

void Link::handle_data(Party& party, const transport::Frame& frame) {
  const MessageKind kind = party.decoder.parse(frame.bytes());
  if (kind == MessageKind::hello) return shake_hands(frame);
  const Heard heard = hear(party.session, kind, party.decoder.header());
  if (heard.kind == Heard::Kind::refuse) throw conversion::MalformedMessage(heard.problem);
  party.session = heard.session;
  if (heard.kind != Heard::Kind::failure) return;
  party.decoder.read(party.ended.emplace());
  throw PeerFailed(*party.ended);
}

void Link::handle_control(Party& party, const transport::Frame& frame) {
  const MessageKind kind = control_decoder_.parse(frame.bytes());
  if (kind == MessageKind::hello) return shake_hands(frame);
  const session::Header& header = control_decoder_.header();
  const bool ours = header.session_id == party.session.session_id && header.epoch == party.session.epoch;
  if (kind != MessageKind::pong || !ours) return;
  session::Pong pong;
  control_decoder_.read(pong);
  party.liveness = on_pong(party.liveness, pong, patience_, now_s());
  send_again_if_lost(party);
}

void Link::ping(Party& party) {
  party.liveness = on_ping(party.liveness, patience_, now_s());
  router_->send(party.control_peer, control_encoder_.encode(sessions_header(party), session::Ping{stamp_ns()}));
}

void Link::look_after(Party& party) {
  const double now = now_s();
  party.liveness = on_look(party.liveness, router_->connected(party.control_peer), patience_, now);
  const Health health = judge(party.liveness, party.session.waits(), patience_, now);
  if (health == Health::fine) return;
  const int rank = health == Health::hung ? party.liveness.pong.awaited_rank : 0;
  const std::int64_t step = party.session.current_step();
  const std::string reason = party.description(rank, step) + " " + describe(health, party.liveness, now) + "." +
                             note_on_damage() + " Look at its log, then run again or resume from a checkpoint.";
  party.ended = FailureReport{ExitCode::component_lost, party.name, party.hello.host, rank, step, reason};
  throw ComponentLost(*party.ended);
}

void Link::send_again_if_lost(Party& party) {
  if (!party.session.waits()) return;
  if (!was_lost(party.liveness, party.session.sequence, party.sent_s, party.resend_after_s)) return;
  party.session = ask_again(party.session);
  party.request = party.encoder.encode_again(party.session.attempt);
  send_request(party);
}

/// A message of this component that breaks the protocol, or numbers of its solver that are not finite.
PeerFailed Link::violation(const Party& party, std::int64_t step, const conversion::MalformedMessage& problem) {
  const bool diverged = dynamic_cast<const conversion::NotFinite*>(&problem) != nullptr;
  const ExitCode code = diverged ? ExitCode::solver_failed : problem.code();
  const std::string reason = party.description(0, step) +
                             (diverged ? " sent a result that is not finite (" : " broke the protocol (") +
                             problem.problem() +
                             (diverged ? "). Look at its log and at the last steps of the trajectory."
                                       : "). Test it with: copepod conformance.");
  return PeerFailed(FailureReport{code, party.name, party.hello.host, 0, step, reason});
}

std::string Link::note_on_damage() const {
  if (damaged_ == 0) return {};
  std::string note = " ";
  note += std::to_string(damaged_) + " message(s) arrived damaged (their checksum did not fit).";
  return note;
}

void Link::throw_if_stopped() const {
  const int signal = stop_signal_ ? stop_signal_() : 0;
  if (signal != 0) throw Interrupted(signal, step_);
}

std::string Party::description(int rank, std::int64_t step) const {
  const std::string process = rank == 0 ? ", process " + std::to_string(hello.pid) : "";
  return "The " + name + " component on host " + hello.host + " (rank " + std::to_string(rank) + process + ")" +
         (step < 0 ? "" : " at step " + std::to_string(step));
}

Parties::Parties(const std::vector<std::string>& controllers) : parties_(2 + controllers.size()) {
  for (std::size_t i = 0; i < parties_.size(); ++i) {
    const auto role = static_cast<session::Role>(std::min<std::size_t>(i, 2));
    parties_[i].session.role = role;
    parties_[i].name = i < 2 ? std::string(name_of(role)) : controllers[i - 2];
  }
}

Party* Parties::by_hello(const Hello& hello) {
  const auto found = std::ranges::find_if(
      parties_, [&](const Party& party) { return party.session.role == hello.role && party.name == hello.party(); });
  return found == parties_.end() ? nullptr : &*found;
}

Party* Parties::by_peer(const std::string& peer, std::string Party::*lane) {
  const auto found = std::ranges::find(parties_, peer, lane);
  return found == parties_.end() ? nullptr : &*found;
}

std::string Parties::missing() const {
  std::vector<std::string> roles;
  for (const Party& party : parties_)
    if (!party.is_complete()) roles.push_back(party.name);
  return listed(roles, " and ");
}

Handshake::Handshake(transport::Router& router, Parties& parties, std::string session_token)
    : router_(router),
      parties_(parties),
      session_token_(std::move(session_token)),
      session_id_(random_number()),
      epoch_(microseconds_since_1970()) {}

std::string Handshake::handle(const transport::Frame& frame, double now_s) {
  const std::optional<Hello> hello = read_hello(decoder_, frame);
  if (!hello) return "A message was ignored (its sender is unknown, and it is not a Hello).";
  Party* const party = parties_.by_hello(*hello);
  // Both lanes of a component carry the same instance number; a lane with another number belongs to another component.
  const bool is_taken = party != nullptr && !(party->data_peer.empty() && party->control_peer.empty()) &&
                        party->hello.instance != hello->instance;
  const auto verdict = judge_hello(*hello, {{}, session_token_, is_taken, frame.identity, party != nullptr});
  if (verdict.accepted()) {
    admit(*party, *hello, frame.peer, *verdict.minor, now_s);
    return {};
  }
  router_.send(frame.peer, encoder_.encode(session::Header{}, session::Refusal{verdict.reason}));
  if (!verdict.is_stranger && hello->lane == Lane::data) throw Refused(verdict.reason);
  return verdict.reason;
}

void Handshake::admit(Party& party, const Hello& hello, const std::string& peer, std::uint32_t minor, double now_s) {
  const bool is_first = party.data_peer.empty() && party.control_peer.empty();
  const bool on_data_lane = hello.lane == Lane::data;
  if (is_first || on_data_lane) party.hello = hello;
  (on_data_lane ? party.data_peer : party.control_peer) = peer;
  if (is_first) {
    party.session = welcomed(party.session, session_id_, epoch_);
    party.liveness.attention_s = now_s;
    party.liveness.last_change_s = now_s;
  }
  router_.send(peer, encoder_.encode(session::Header{}, session::Welcome{minor, session_id_, epoch_}));
}

}  // namespace copepod::coupler
