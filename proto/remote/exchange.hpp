#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "remote/parties.hpp"
#include "remote/reception.hpp"
#include "transport/router.hpp"

namespace copepod::remote {

/// Requests and replies: sends a request, waits for its answer, and keeps an eye on both components
/// meanwhile.
class Exchange {
 public:
  /// The references outlive this object.
  Exchange(transport::Router& router, Parties& parties, const std::string& session_token,
           const session::Patience& patience, const std::atomic<int>* stop_signal);

  /// Waits until both components have said Hello on both lanes.
  void await_components(double deadline_s);

  /// Sends a request about `step` and waits for the reply.
  /// @param encode  (Encoder&, const Header&) -> bytes
  /// @return the reply, to be read before the next call
  /// @throws what class Link says
  template <class Encode>
  const conversion::Decoder& ask(session::Role role, session::MessageKind request, std::int64_t step,
                                 Encode encode) {
    Party& party = open_request(role, request, step);
    party.request = encode(party.encoder, header_of(party.session));
    return await_reply(party);
  }

  /// One round of waiting: at most one message, or a look at both components if there is none.
  void attend();

  /// Tells a component why the run ends, if it is still there.
  void abort(const FailureReport& report);

 private:
  Party& open_request(session::Role role, session::MessageKind request, std::int64_t step);
  const conversion::Decoder& await_reply(Party& party);
  void send_request(Party& party);
  [[nodiscard]] transport::Duration time_to_next_ping(double now_s) const;
  void handle(const transport::Frame& frame);
  void handle_data(Party& party, const transport::Frame& frame);
  void handle_control(Party& party, const transport::Frame& frame);
  void ping(Party& party);
  void look_after(Party& party);
  void send_again_if_lost(Party& party);
  [[nodiscard]] std::string note_on_damage() const;
  void throw_if_stopped() const;

  transport::Router& router_;
  Parties& parties_;
  Reception reception_;
  session::Patience patience_;
  const std::atomic<int>* stop_signal_;
  transport::Frame frame_;
  conversion::Encoder control_encoder_;
  conversion::Decoder control_decoder_;
  std::int64_t step_ = -1;    ///< of the newest request
  std::int64_t damaged_ = 0;  ///< messages whose checksum did not fit
};

}  // namespace copepod::remote
