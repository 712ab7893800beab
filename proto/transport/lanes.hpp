#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace copepod::transport {

// Keys of CURVE (ZeroMQ's encryption and authentication, RFC 26): Curve25519, written in Z85, 40 characters.
// A run has a pair for each of coupler, fluid and body; the deploy command makes them anew and takes them
// away again.

/// What the coupler needs: its secret key, and who may come in.
struct CouplerKeys {
  std::string secret;
  std::map<std::string, std::string> admitted;  ///< public key to the name of the role that it belongs to
};

/// What a component needs: its secret key, and how it recognises the coupler.
struct ComponentKeys {
  std::string secret;
  std::string coupler;  ///< public key
};

/// Reads a file of lines "secret KEY", "fluid PUBLIC_KEY", "body PUBLIC_KEY".
/// @throws CaseError if it cannot be read, others than its owner can read it, or a key is missing or none
CouplerKeys read_coupler_keys(const std::string& path);

/// Reads a file of lines "secret KEY", "coupler PUBLIC_KEY".
/// @throws CaseError as above
ComponentKeys read_component_keys(const std::string& path);

using Bytes = std::span<const std::byte>;
using Duration = std::chrono::nanoseconds;

/// One message as it arrived. The bytes belong to the end of the lane that received it, until
/// it receives again.
struct Frame {
  std::string peer;      ///< who sent it; empty at the component's end, where there is one peer only
  std::string identity;  ///< with keys: the role whose key the sender holds
  Bytes content;

  [[nodiscard]] Bytes bytes() const { return content; }
};

/// The coupler's end: one address, many peers. Used by one thread.
class Router {
 public:
  virtual ~Router() = default;

  /// Waits at most `wait` for the next message.
  /// @return false if none came, or one that is not of the protocol
  virtual bool receive(Frame& frame, Duration wait) = 0;

  /// Hands a message to the transport; never blocks.
  /// @return false if the peer cannot be reached, or reads nothing
  virtual bool send(const std::string& peer, Bytes bytes) = 0;

  /// Next remark about a stranger, as one sentence for a log; empty if there is none.
  virtual std::string next_remark() { return {}; }

  /// Whether the connection over which the peer spoke last still stands. Unknown peers are not connected.
  virtual bool connected(const std::string& peer) = 0;
};

/// A component's end of one lane: one peer, the coupler. Used by one thread. Messages that are sent before
/// the coupler is there wait for it; a broken connection is made again by itself.
class Dealer {
 public:
  virtual ~Dealer() = default;

  /// Waits at most `wait` for the next message; false if none came.
  virtual bool receive(Frame& frame, Duration wait) = 0;

  /// Hands a message to the transport; false if its queue is full.
  virtual bool send(Bytes bytes) = 0;

  /// Whether the coupler is connected now.
  virtual bool connected() = 0;

  /// Whether the coupler has given up its address, and with it the run.
  virtual bool address_is_gone() { return false; }

  /// Whether the coupler turns us away at the door: a key is wrong or missing, at our end or at its.
  virtual bool turned_away() { return false; }
};

/// Binds a ROUTER socket. For ipc the path is guarded by a lock file beside it.
/// @param keys  messages are encrypted, and only holders of an admitted key may connect
/// @throws Refused if the address is taken or cannot be bound, CaseError if it is not valid or needs keys, StorageError
///         if the disk is full
std::unique_ptr<Router> bind_router(const std::string& endpoint, const std::optional<CouplerKeys>& keys = std::nullopt);

/// Connects a DEALER socket; the coupler need not be there yet.
/// @param name  name for the coupler's socket, unique among its peers
/// @throws CaseError if the address is not valid or needs keys
std::unique_ptr<Dealer> connect_dealer(const std::string& endpoint, const std::string& name,
                                       const std::optional<ComponentKeys>& keys = std::nullopt);

}  // namespace copepod::transport
