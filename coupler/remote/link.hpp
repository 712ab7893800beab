#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "contract/capabilities.hpp"
#include "contract/errors.hpp"
#include "conversion/limits.hpp"
#include "remote/handshake.hpp"
#include "system/process.hpp"
#include "transport/lanes.hpp"

namespace copepod::coupler {

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
