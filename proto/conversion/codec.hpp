#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "contract/body_setup.hpp"
#include "contract/controller.hpp"
#include "contract/errors.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "conversion/limits.hpp"
#include "session/messages.hpp"

namespace google::protobuf {
class Message;
}

namespace copepod::v1 {
class Envelope;
}  // namespace copepod::v1

namespace copepod::conversion {

/// A message ends with its checksum: the Envelope's field 15, one tag byte (0x79) and the XXH3 hash (64 bits,
/// seed 0, little-endian) of all bytes before the tag. Any Protobuf parser skips it. A check distinguishes a
/// message that was damaged on its way from one that was sent with errors.
inline constexpr std::size_t kChecksumBytes = 9;

/// Writes the checksum into the last `kChecksumBytes` bytes of `message`, which must have as many.
void write_checksum(std::span<std::byte> message);

/// Whether the last bytes are the checksum of those before them.
bool is_intact(std::span<const std::byte> message);

using Bytes = std::span<const std::byte>;

/// The messages of every step hold nothing but arrays: fields 1, 2, … of type `repeated double`. On the wire
/// each is a tag, its length in bytes, and the numbers as they lie in memory [Protocol Buffers, "Encoding"],
/// so they are written to the wire and read from it in place, without a message object in between.
inline constexpr std::size_t kMostArrays = 7;

using Arrays = std::array<std::span<const double>, kMostArrays>;  ///< field 1 first; unused ones are empty

/// Bytes that an Envelope needs for its field `message` with these arrays.
std::size_t size_of_arrays(int message, const Arrays& arrays);

/// Writes that field, `size_of_arrays` bytes.
void write_arrays(int message, const Arrays& arrays, std::byte* target);

/// Where a message of arrays lies in the bytes of its Envelope; the numbers need not be aligned.
struct ArraysOnWire {
  int message = 0;        ///< number of the Envelope's field
  std::size_t begin = 0;  ///< of that field; before it is the header
  std::array<Bytes, kMostArrays> arrays{};
};

/// @param envelope  without its checksum
/// @return nothing for all other messages, among them those that hold the same in one of the rarer ways that
///         Protobuf allows (arrays in pieces or unpacked, fields in another order or unknown): for its parser
std::optional<ArraysOnWire> find_arrays(Bytes envelope);

/// Turns contract structs into the bytes of an Envelope.
///
/// Message object and buffer are kept between calls: encoding the same kind of message again allocates
/// nothing. The bytes stay valid until the next call. Steps travel in the header: `encode` sets header.step
/// from the struct where the struct has one.
class Encoder {
 public:
  Encoder();
  ~Encoder();

  Bytes encode(const session::Header& header, const session::Hello& hello);
  Bytes encode(const session::Header& header, const session::Welcome& welcome);
  Bytes encode(const session::Header& header, const session::Refusal& refusal);
  Bytes encode(const session::Header& header, const FluidSetup& setup);
  Bytes encode(const session::Header& header, const BodySetup& setup);
  Bytes encode(const session::Header& header, const ControllerSetup& setup);
  Bytes encode(const session::Header& header, const session::Configured& configured);
  Bytes encode(const session::Header& header, const Kinematics& kinematics);
  Bytes encode(const session::Header& header, const Loads& loads);
  Bytes encode(const session::Header& header, const AppliedLoads& applied);
  Bytes encode(const session::Header& header, const Observation& observation);
  Bytes encode(const session::Header& header, const std::vector<double>& action);
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

/// Turns the bytes of an Envelope into contract structs and checks them on the way.
///
/// Memory is kept between calls: decoding messages of the same size again allocates nothing. `parse` first,
/// then, while the bytes are still there, the `read` of the kind that it returned; calling another `read` is
/// a bug. Every function throws MalformedMessage for bytes from outside that make no sense; none crashes or
/// allocates more than a multiple of the message's size.
class Decoder {
 public:
  Decoder();
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
  void read(ControllerSetup& setup) const;
  void read(session::Configured& configured) const;
  void read(session::CheckpointPath& path) const;
  void read(SolverSummary& summary) const;
  void read(session::Ping& ping) const;
  void read(session::Pong& pong) const;
  void read(session::Saved& saved) const;
  void read(FailureReport& failure) const;  ///< of a Failure or an Abort

  /// @param bodies  number of bodies of the setup; another number is refused
  void read(Kinematics& kinematics, Eigen::Index bodies) const;
  /// @param flow  values of FlowSampling in this step
  void read(Loads& loads, Eigen::Index bodies, Eigen::Index flow) const;
  void read(Loads& loads, Eigen::Index bodies) const;
  void read(AppliedLoads& applied, Eigen::Index bodies, Eigen::Index actuators, Eigen::Index driving_nodes) const;
  void read(Observation& observation, Eigen::Index bodies, Eigen::Index flow = 0) const;
  /// @param action  has the length of that of the setup
  void read(std::vector<double>& action) const;

 private:
  struct Buffers;
  [[nodiscard]] const v1::Envelope& envelope() const;  ///< that was parsed
  std::unique_ptr<Buffers> buffers_;
};

/// The message alone, as bytes: for the ranks of a component, and for `--estimate`.
std::string to_bytes(const FluidSetup& setup);
std::string to_bytes(const BodySetup& setup);

/// A setup as JSON, with the names of its message.
std::string to_json(const FluidSetup& setup);
std::string to_json(const BodySetup& setup);

/// @throws MalformedMessage for bytes that are not such a message, wrong lengths, unknown kinds, numbers that are not
/// finite, or indices that do not exist
FluidSetup fluid_setup_from_bytes(std::string_view bytes);
BodySetup body_setup_from_bytes(std::string_view bytes);

}  // namespace copepod::conversion
