#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "contract/capabilities.hpp"
#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "conversion/limits.hpp"
#include "session/coupler_session.hpp"
#include "session/messages.hpp"
#include "system/process.hpp"
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

/// How the coupler reaches its components and how long it waits for them.
struct LinkSettings {
  std::string endpoint;                   ///< ipc:///… or tcp://…
  std::string session;                    ///< token that every component must show
  std::string key_file;                   ///< CURVE keys of the coupler; empty: none
  double connect_deadline_s = 60.0;       ///< for both Hellos
  double silence_s = 3.0;                 ///< without a pong for this long: frozen or dead
  double progress_deadline_s = 60.0;      ///< pongs, but neither step, phase nor progress moves: hung
  std::string wire_file;                  ///< where to record every message; empty: nowhere
  std::vector<std::string> controllers;   ///< their names
  std::function<int()> stop_signal = {};  ///< non-zero: waits throw Interrupted within 100 ms
};

/// Number of a component among those of a run: the controllers follow, in the order of the case.
enum Number : std::size_t { kFluid, kBody, kFirstController };

/// The coupler's end of the wire to the components of a run: sends a request, waits for its reply, and watches all of
/// them meanwhile.
///
/// Legal call order:
///   construct  ->  await_components  ->  RemoteFluid, RemoteBody, RemoteController (they keep a reference)  ->  finish
///   stay_in_touch_during between any two of them; abort from anywhere.
///
/// Owned and used by one thread. While any call waits, the control lanes of all components are pinged, so
/// that the loss of one is also noticed while the coupler waits for another. Errors that any waiting call
/// throws: PeerFailed (reported by a component, or a breach of the protocol that names it), ComponentLost
/// (died, froze or hung; names component, host, rank and the step of its open request), Interrupted
/// (stop_signal). After the first two every request to that component throws the same again.
class Link {
 public:
  /// Binds the endpoint.
  /// @throws Refused if another coupler that is alive holds the same ipc path, or the address cannot be
  /// bound; CaseError if the address needs keys or the key file cannot be used
  explicit Link(const LinkSettings& settings);
  /// The same over any other transport, for tests.
  Link(const LinkSettings& settings, std::unique_ptr<transport::Router> router);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Waits for the Hello of every component on both lanes and welcomes them.
  /// @throws DeadlinePassed naming the missing ones, Refused for a component of another protocol version
  void await_components();

  /// Legal after await_components.
  [[nodiscard]] const Capabilities& capabilities(std::size_t number) const {
    return parties_[number].hello.capabilities;
  }

  /// Runs a task of the coupler in another thread and pings the components meanwhile; otherwise they would take the
  /// coupler for lost.
  /// @throws also what `work` throws; nothing is thrown before `work` is over
  void stay_in_touch_during(const std::function<void()>& work);

  /// Ends the run: every component receives Finish, answers it and exits with 0.
  void finish();

  /// Reports to every component that is still connected why the run ends; never throws, never waits.
  void abort(const FailureReport& report) noexcept;

  /// Sends a request about `step`, waits for the reply and reads it.
  /// @param encode  (Encoder&, const Header&) -> bytes
  /// @param read    (const Decoder&) of the reply
  template <class Encode, class Read>
  void ask(std::size_t number, session::MessageKind request, std::int64_t step, Encode encode, Read read) {
    Party& party = open_request(number, request, step);
    party.request = encode(party.encoder, header_of(party.session));
    await_reply(party);
    try {
      read(party.decoder);
    } catch (const conversion::MalformedMessage& error) {
      throw violation(party, step, error);
    }
  }

 private:
  Party& open_request(std::size_t number, session::MessageKind request, std::int64_t step);
  void await_reply(Party& party);
  bool attend(transport::Duration longest);
  void send_request(Party& party);
  [[nodiscard]] transport::Duration time_to_next_ping(double now_s) const;
  void handle(const transport::Frame& frame);
  void shake_hands(const transport::Frame& frame) {
    if (const std::string refused = handshake_.handle(frame, now_s()); !refused.empty()) log_remark(refused);
  }
  void log_remark(const std::string& text);
  void handle_data(Party& party, const transport::Frame& frame);
  void handle_control(Party& party, const transport::Frame& frame);
  void ping(Party& party);
  void look_after(Party& party);
  void send_again_if_lost(Party& party);
  static PeerFailed violation(const Party& party, std::int64_t step, const conversion::MalformedMessage& problem);
  [[nodiscard]] std::string note_on_damage() const;
  void throw_if_stopped() const;

  double connect_deadline_s_;
  session::Patience patience_;
  std::function<int()> stop_signal_;
  std::unique_ptr<transport::Router> router_;
  Parties parties_;
  Handshake handshake_;
  transport::Frame frame_;
  conversion::Encoder control_encoder_;
  conversion::Decoder control_decoder_;
  std::int64_t step_ = -1;     ///< of the newest request
  std::int64_t damaged_ = 0;   ///< messages whose checksum did not fit
  std::uint64_t remarks_ = 0;  ///< about strangers
};

}  // namespace copepod::coupler
