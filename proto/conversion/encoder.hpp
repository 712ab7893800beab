#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "contract/body_setup.hpp"
#include "contract/errors.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"
#include "conversion/packed_arrays.hpp"
#include "session/header.hpp"
#include "session/message_kind.hpp"
#include "session/messages.hpp"

namespace google::protobuf {
class Message;
}

namespace copepod::conversion {

/// Turns contract structs into the bytes of an Envelope.
///
/// Message object and buffer are kept between calls: encoding the same kind of message again allocates
/// nothing. The bytes stay valid until the next call. Steps travel in the header: `encode` sets header.step
/// from the struct where the struct has one.
class Encoder {
 public:
  Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  ~Encoder();

  Bytes encode(const session::Header& header, const session::Hello& hello);
  Bytes encode(const session::Header& header, const session::Welcome& welcome);
  Bytes encode(const session::Header& header, const session::Refusal& refusal);
  Bytes encode(const session::Header& header, const FluidSetup& setup);
  Bytes encode(const session::Header& header, const BodySetup& setup);
  Bytes encode(const session::Header& header, const session::Configured& configured);
  Bytes encode(const session::Header& header, const Kinematics& kinematics);
  Bytes encode(const session::Header& header, const Loads& loads);
  Bytes encode(const session::Header& header, const AppliedLoads& applied);
  Bytes encode(const session::Header& header, const SolverSummary& summary);
  Bytes encode(const session::Header& header, const session::Ping& ping);
  Bytes encode(const session::Header& header, const session::Pong& pong);
  Bytes encode(const session::Header& header, const FailureReport& failure);

  /// An Abort that carries what ended the run.
  Bytes encode_abort(const session::Header& header, const FailureReport& failure);

  /// Save or Restore.
  Bytes encode(const session::Header& header, session::MessageKind kind, const session::CheckpointPath& path);

  Bytes encode(const session::Header& header, const session::Saved& saved);

  /// A message without fields: kinematics_request, restored, summarise, finish, finished.
  Bytes encode(const session::Header& header, session::MessageKind kind);

  /// The last message once more, as a repeated attempt.
  Bytes encode_again(std::uint32_t attempt);

 private:
  struct Buffers;
  template <class Struct>
  Bytes put(const session::Header& header, session::MessageKind kind, const Struct& sent);
  google::protobuf::Message& body(session::MessageKind kind);  ///< receives the fields of the message
  Bytes serialise(const session::Header& header);
  Bytes serialise(const session::Header& header, int message, const Arrays& arrays);
  Bytes finish(const session::Header& header);
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace copepod::conversion
