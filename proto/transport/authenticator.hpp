#pragma once

#include <map>
#include <string>
#include <vector>

#include <zmq.hpp>

namespace copepod::transport {

/// Decides which peers may connect to a socket with CURVE, by answering ZeroMQ's authentication requests
/// (ZAP, RFC 27): the holder of an admitted key connects under the name that belongs to it, all others are
/// rejected. Used by the thread of the socket, between two waits; exists before the socket is bound.
class Authenticator {
 public:
  /// @param admitted  public key (Z85) to name; every message carries the name of its sender ("User-Id")
  Authenticator(zmq::context_t& context, const std::map<std::string, std::string>& admitted);

  /// Answers all requests that have arrived.
  /// @return addresses of those who were rejected
  std::vector<std::string> answer();

 private:
  zmq::socket_t socket_;
  std::map<std::string, std::string> admitted_;  ///< public key as bytes
};

}  // namespace copepod::transport
