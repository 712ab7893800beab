#pragma once

#include <string>

#include "transport/frame.hpp"

namespace copepod::transport {

/// The coupler's end: one address, many peers. Used by one thread.
class Router {
 public:
  Router() = default;
  Router(const Router&) = delete;
  Router& operator=(const Router&) = delete;
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

}  // namespace copepod::transport
