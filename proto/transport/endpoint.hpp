#pragma once

#include <cstdint>
#include <string>

namespace copepod::transport {

inline constexpr std::int64_t kLargestMessage = 256LL << 20;  ///< bytes; larger ones break the connection

/// Checks an endpoint before ZeroMQ sees it, so that people read what is wrong.
/// @throws CaseError unless it is ipc:///absolute/path of at most 107 bytes, or tcp://host:port
void check_endpoint(const std::string& endpoint);

/// Whether messages to that endpoint never leave this machine: ipc, or tcp to a loopback address.
bool stays_on_this_machine(const std::string& endpoint);

/// @throws CaseError if other machines could listen and take part
void require_keys_off_this_machine(const std::string& endpoint, bool has_keys);

/// The same with the address of the host in place of its name, IPv4 if it has one, so that both sides use the same one.
/// @throws CaseError if this machine cannot resolve the name
std::string with_numeric_host(const std::string& endpoint);

/// The socket file of an ipc endpoint; empty for others.
std::string ipc_path(const std::string& endpoint);

}  // namespace copepod::transport
