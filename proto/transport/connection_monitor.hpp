#pragma once

#include <chrono>
#include <string>

#include <zmq.hpp>

namespace copepod::transport {

/// Reports what happens to the connections of a socket, which ZeroMQ sends to a second, inner socket. A
/// handshake fails for good (turned_away) if a key is refused or only one side has keys; it is broken off,
/// and tried again, if the peer cannot read it or ends.
class ConnectionMonitor {
 public:
  enum class Event { none, opened, closed, turned_away, broken_off, other, stopped };

  /// @param name  unique in the context
  /// @param wait  of next(), at most
  ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched, const std::string& name,
                    std::chrono::milliseconds wait = {});
  ConnectionMonitor(const ConnectionMonitor&) = delete;
  ConnectionMonitor& operator=(const ConnectionMonitor&) = delete;
  ~ConnectionMonitor();

  /// Ends it, and a wait of another thread in next(); by the thread that uses the watched socket, before that closes.
  void stop();

  /// The next event; none if there was none in time, stopped after stop().
  /// @param descriptor  of the connection it is about
  Event next(int& descriptor);

 private:
  zmq::socket_t& watched_;
  zmq::socket_t socket_;
};

}  // namespace copepod::transport
