#pragma once

#include "transport/frame.hpp"

namespace copepod::transport {

/// A component's end of one lane: one peer, the coupler. Used by one thread. Messages that are sent before
/// the coupler is there wait for it; a broken connection is made again by itself.
class Dealer {
 public:
  Dealer() = default;
  Dealer(const Dealer&) = delete;
  Dealer& operator=(const Dealer&) = delete;
  virtual ~Dealer() = default;

  /// Waits at most `wait` for the next message; false if none came.
  virtual bool receive(Frame& frame, Duration wait) = 0;

  /// Hands a message to the transport; false if its queue is full.
  virtual bool send(Bytes bytes) = 0;

  /// Whether the coupler is connected now.
  virtual bool connected() = 0;

  /// Whether the coupler turns us away at the door: a key is wrong or missing, at our end or at its.
  virtual bool turned_away() { return false; }
};

}  // namespace copepod::transport
