#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "contract/body_setup.hpp"
#include "contract/errors.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"
#include "conversion/malformed_message.hpp"
#include "session/header.hpp"
#include "session/message_kind.hpp"
#include "session/messages.hpp"

namespace copepod::v1 {
class Envelope;
}

namespace copepod::conversion {

/// Turns the bytes of an Envelope into contract structs and checks them on the way.
///
/// Memory is kept between calls: decoding messages of the same size again allocates nothing. `parse` first,
/// then, while the bytes are still there, the `read` of the kind that it returned; calling another `read` is
/// a bug. Every function throws MalformedMessage for bytes from outside that make no sense; none crashes or
/// allocates more than a multiple of the message's size.
class Decoder {
 public:
  Decoder();
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder();

  /// @param bytes  stay where they are until the message was read: its arrays are not copied before
  /// @return the message's kind, never `none`
  /// @throws DamagedMessage if the bytes do not end with their checksum
  session::MessageKind parse(std::span<const std::byte> bytes);

  [[nodiscard]] session::MessageKind kind() const;
  [[nodiscard]] const session::Header& header() const;

  void read(session::Hello& hello) const;
  void read(session::Welcome& welcome) const;
  void read(session::Refusal& refusal) const;
  void read(FluidSetup& setup) const;
  void read(BodySetup& setup) const;
  void read(session::Configured& configured) const;
  void read(session::CheckpointPath& path) const;
  void read(SolverSummary& summary) const;
  void read(session::Ping& ping) const;
  void read(session::Pong& pong) const;
  void read(session::Saved& saved) const;
  void read(FailureReport& failure) const;  ///< of a Failure or an Abort

  /// @param bodies  number of bodies of the setup; another number is refused
  void read(Kinematics& kinematics, Eigen::Index bodies) const;
  void read(Loads& loads, Eigen::Index bodies) const;
  void read(AppliedLoads& applied, Eigen::Index bodies, Eigen::Index actuators, Eigen::Index driving_nodes) const;

 private:
  struct Buffers;
  [[nodiscard]] const v1::Envelope& envelope() const;  ///< that was parsed
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace copepod::conversion
