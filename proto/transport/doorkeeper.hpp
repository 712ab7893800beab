#pragma once

#include <map>
#include <string>

#include <zmq.hpp>

namespace copepod::transport {

/// Decides who may connect to a socket with CURVE, by answering ZeroMQ's authentication requests (ZAP, RFC
/// 27): whoever holds a key that is admitted comes in under the name that it is admitted with, everybody else
/// is turned away. Used by the thread of the socket, between two waits; exists before the socket is bound.
class Doorkeeper {
 public:
  /// @param admitted  public key (Z85) to name; every message tells the name of its sender ("User-Id")
  Doorkeeper(zmq::context_t& context, const std::map<std::string, std::string>& admitted);

  /// Answers everybody who waits at the door.
  void answer();

 private:
  zmq::socket_t socket_;
  std::map<std::string, std::string> admitted_;  ///< public key as bytes
};

}  // namespace copepod::transport
