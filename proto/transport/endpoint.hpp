#pragma once

#include <string>

namespace copepod::transport {

/// Checks an endpoint before ZeroMQ sees it, so that people read what is wrong.
/// @throws CaseError unless it is ipc:///absolute/path of at most 107 bytes, or tcp://host:port
void check_endpoint(const std::string& endpoint);

/// The socket file of an ipc endpoint; empty for others.
std::string ipc_path(const std::string& endpoint);

}  // namespace copepod::transport
