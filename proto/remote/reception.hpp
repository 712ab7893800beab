#pragma once

#include <cstdint>
#include <string>

#include "conversion/decoder.hpp"
#include "conversion/encoder.hpp"
#include "remote/parties.hpp"
#include "transport/router.hpp"

namespace copepod::remote {

/// Receives components at the door: judges their Hellos and welcomes or refuses them.
class Reception {
 public:
  /// Both references outlive this object.
  Reception(transport::Router& router, Parties& parties, std::string session_token);

  /// A message from a peer that is no component yet, or a repeated Hello.
  /// Anything but a well-formed Hello is ignored: on a tcp port anybody may talk.
  /// @throws Refused if a component with our token cannot take part, once it has asked on its data lane:
  /// there it
  ///         heeds our Refusal
  void handle(const transport::Frame& frame, double now_s);

 private:
  void admit(const session::Hello& hello, const std::string& peer, std::uint32_t minor, double now_s);
  void refuse(const std::string& peer, const std::string& reason);
  [[nodiscard]] bool is_role_taken(const session::Hello& hello) const;

  transport::Router& router_;
  Parties& parties_;
  std::string session_token_;
  std::uint64_t session_id_;
  std::uint64_t epoch_;
  conversion::Decoder decoder_;
  conversion::Encoder encoder_;
};

}  // namespace copepod::remote
