#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "conversion/codec.hpp"
#include "session/coupler_session.hpp"
#include "session/messages.hpp"
#include "transport/lanes.hpp"

namespace copepod::coupler {

/// What the coupler remembers of one component.
struct Party {
  std::string name;       ///< session::Hello::party
  session::Hello hello;   ///< of the data lane
  std::string data_peer;  ///< names of its lanes in the transport; empty before its Hello
  std::string control_peer;
  session::CouplerSession session;
  session::Liveness liveness;
  conversion::Encoder encoder;  ///< keeps the bytes of the open request, in case it has to be sent again
  conversion::Decoder decoder;  ///< keeps the reply until the next one
  std::span<const std::byte> request;
  double sent_s = 0.0;                 ///< when the request was last sent
  double resend_after_s = 0.0;         ///< time after which a pong shows whether it was lost
  std::optional<FailureReport> ended;  ///< why it answers no more

  [[nodiscard]] bool is_complete() const { return !data_peer.empty() && !control_peer.empty(); }
  [[nodiscard]] bool is_finished() const { return session.state == session::State::done; }

  /// "The fluid component on host x (rank 0, process 123) at step 7", without the step if it is negative.
  [[nodiscard]] std::string description(int rank, std::int64_t step) const;
};

/// The components of a run: fluid, bodies, and the controllers in the order of the case.
class Parties {
 public:
  explicit Parties(const std::vector<std::string>& controllers);

  [[nodiscard]] Party& operator[](std::size_t number) { return parties_[number]; }
  [[nodiscard]] const Party& operator[](std::size_t number) const { return parties_[number]; }
  [[nodiscard]] std::size_t size() const { return parties_.size(); }

  /// The one that a Hello is of, or null.
  [[nodiscard]] Party* by_hello(const session::Hello& hello);

  /// The component that the name of a lane belongs to, or null.
  /// @param lane  data_peer or control_peer
  [[nodiscard]] Party* by_peer(const std::string& peer, std::string Party::*lane);

  [[nodiscard]] bool are_complete() const { return std::ranges::all_of(parties_, &Party::is_complete); }

  /// "fluid", "body" or "fluid and body", …: whose Hello is still missing on a lane.
  [[nodiscard]] std::string missing() const;

  auto begin() { return parties_.begin(); }
  auto end() { return parties_.end(); }
  [[nodiscard]] auto begin() const { return parties_.begin(); }
  [[nodiscard]] auto end() const { return parties_.end(); }

 private:
  std::vector<Party> parties_;
};

/// Admits components to a run: judges their Hellos, then welcomes or refuses them.
class Handshake {
 public:
  /// Both references outlive this object.
  Handshake(transport::Router& router, Parties& parties, std::string session_token);

  /// A message from a peer that is not a component yet, or a repeated Hello.
  /// Anything but a well-formed Hello is ignored: a tcp port is open to any sender.
  /// @return why a stranger was refused; empty if none was
  /// @throws Refused if a component with our token cannot take part, once it has asked on its data lane, where it reads
  ///         our Refusal
  std::string handle(const transport::Frame& frame, double now_s);

 private:
  void admit(Party& party, const session::Hello& hello, const std::string& peer, std::uint32_t minor, double now_s);

  transport::Router& router_;
  Parties& parties_;
  std::string session_token_;
  std::uint64_t session_id_;
  std::uint64_t epoch_;
  conversion::Decoder decoder_;
  conversion::Encoder encoder_;
};

}  // namespace copepod::coupler
