#pragma once

#include <map>
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

}  // namespace copepod::transport
