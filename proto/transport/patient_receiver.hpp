#pragma once

#include <algorithm>
#include <chrono>

#include <zmq.hpp>

#include "transport/frame.hpp"
#include "transport/patient_wait.hpp"

namespace copepod::transport {

/// Receives with a deadline in the way that costs least: ZeroMQ's own blocking receive, whose limit is set
/// only when it changes. Polling would ask the kernel three times instead of once.
class PatientReceiver {
 public:
  explicit PatientReceiver(WaitPolicy policy) : policy_(policy) {}

  /// The first part of the next message; false if none came within `wait`, or a signal came first.
  bool receive(zmq::socket_t& socket, zmq::message_t& part, Duration wait) {
    const auto receive_now = [&] { return socket.recv(part, zmq::recv_flags::dontwait).has_value(); };
    if (policy_.yield_for > Duration::zero() && try_for_a_while(policy_, wait, receive_now)) return true;
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
  WaitPolicy policy_;
  std::chrono::milliseconds limit_{-1};
};

}  // namespace copepod::transport
