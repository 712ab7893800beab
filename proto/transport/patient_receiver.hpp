#pragma once

#include <algorithm>
#include <chrono>

#include <zmq.hpp>

#include "transport/frame.hpp"

namespace copepod::transport {

/// Receives with a deadline in the cheapest way (docs/decisions/how_the_data_lanes_wait.md): ZeroMQ's own
/// blocking receive, whose limit is set only when it changes. Polling would take three system calls instead
/// of one.
class PatientReceiver {
 public:
  /// The first part of the next message; false if none came within `wait`, or a signal came first.
  bool receive(zmq::socket_t& socket, zmq::message_t& part, Duration wait) {
    const auto limit = std::chrono::ceil<std::chrono::milliseconds>(std::max(wait, Duration::zero()));
    if (limit != limit_) {
      socket.set(zmq::sockopt::rcvtimeo, static_cast<int>(limit.count()));
      limit_ = limit;
    }
    try {
      return socket.recv(part).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
      return false;
    }
  }

 private:
  std::chrono::milliseconds limit_{-1};
};

}  // namespace copepod::transport
