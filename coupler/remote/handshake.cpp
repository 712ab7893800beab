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
