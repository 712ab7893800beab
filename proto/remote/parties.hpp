#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "conversion/decoder.hpp"
#include "conversion/encoder.hpp"
#include "session/coupler_session.hpp"
#include "session/liveness.hpp"
#include "session/messages.hpp"

namespace copepod::remote {

/// What the coupler knows of one component.
struct Party {
  session::Hello hello;   ///< of the data lane
  std::string data_peer;  ///< names of its lanes in the transport; empty before its Hello
  std::string control_peer;
  session::CouplerSession session;
  session::Liveness liveness;
  conversion::Encoder encoder;  ///< keeps the bytes of the open request, should it have to be sent again
  conversion::Decoder decoder;  ///< keeps the reply until the next one
  std::span<const std::byte> request;
  double sent_s = 0.0;          ///< when the request was sent last
  double resend_after_s = 0.0;  ///< whether it was lost shows so long after

  [[nodiscard]] bool is_complete() const { return !data_peer.empty() && !control_peer.empty(); }
  [[nodiscard]] bool is_finished() const { return session.state == session::State::done; }

  /// "The fluid component on host x (rank 0, process 123) at step 7"
  [[nodiscard]] std::string description(int rank = 0) const;
};

/// The two components of a run.
class Parties {
 public:
  Parties();

  [[nodiscard]] Party& of(session::Role role) { return parties_[static_cast<std::size_t>(role)]; }
  [[nodiscard]] const Party& of(session::Role role) const { return parties_[static_cast<std::size_t>(role)]; }

  /// The component that one of these names belongs to, or null.
  [[nodiscard]] Party* by_data_peer(const std::string& peer);
  [[nodiscard]] Party* by_control_peer(const std::string& peer);

  [[nodiscard]] bool are_complete() const { return parties_[0].is_complete() && parties_[1].is_complete(); }

  /// "fluid", "body" or "fluid and body": whose Hello is still missing on some lane.
  [[nodiscard]] std::string missing() const;

  auto begin() { return parties_.begin(); }
  auto end() { return parties_.end(); }
  [[nodiscard]] auto begin() const { return parties_.begin(); }
  [[nodiscard]] auto end() const { return parties_.end(); }

 private:
  std::array<Party, 2> parties_;
};

}  // namespace copepod::remote
