#include "remote/handshake.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "conversion/limits.hpp"
#include "system/process.hpp"

namespace copepod::coupler {

using session::Hello;
using session::Lane;
using session::MessageKind;

namespace {

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

std::string Party::description(int rank, std::int64_t step) const {
  const std::string process = rank == 0 ? ", process " + std::to_string(hello.pid) : "";
  return "The " + std::string(name_of(session.role)) + " component on host " + hello.host + " (rank " +
         std::to_string(rank) + process + ")" + (step < 0 ? "" : " at step " + std::to_string(step));
}

Parties::Parties() {
  of(session::Role::fluid).session.role = session::Role::fluid;
  of(session::Role::body).session.role = session::Role::body;
}

Party* Parties::by_peer(const std::string& peer, std::string Party::*lane) {
  const auto found = std::ranges::find(parties_, peer, lane);
  return found == parties_.end() ? nullptr : &*found;
}

std::string Parties::missing() const {
  std::vector<std::string> roles;
  for (const Party& party : parties_)
    if (!party.is_complete()) roles.emplace_back(name_of(party.session.role));
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
  const auto verdict = judge_hello(*hello, {{}, session_token_, is_role_taken(*hello), frame.identity});
  if (verdict.accepted()) {
    admit(*hello, frame.peer, *verdict.minor, now_s);
    return {};
  }
  router_.send(frame.peer, encoder_.encode(session::Header{}, session::Refusal{verdict.reason}));
  if (!verdict.is_stranger && hello->lane == Lane::data) throw Refused(verdict.reason);
  return verdict.reason;
}

/// Both lanes of a component carry the same instance number; a lane with another number belongs to
/// another component.
bool Handshake::is_role_taken(const Hello& hello) const {
  const Party& party = parties_.of(hello.role);
  const bool is_known = !party.data_peer.empty() || !party.control_peer.empty();
  return is_known && party.hello.instance != hello.instance;
}

void Handshake::admit(const Hello& hello, const std::string& peer, std::uint32_t minor, double now_s) {
  Party& party = parties_.of(hello.role);
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
