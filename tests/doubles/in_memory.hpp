#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "transport/lanes.hpp"

namespace copepod::transport {

/// A wire inside one process, for tests: any number of dealers and one router, each end used
/// by its own thread.
class InMemoryWire {
 public:
  InMemoryWire();
  ~InMemoryWire();

  std::unique_ptr<Router> make_router();
  std::unique_ptr<Dealer> make_dealer(const std::string& name);

  /// Breaks or restores the connection of a dealer, as a network or a killed process would.
  void disconnect(const std::string& name);
  void reconnect(const std::string& name);

  /// Loses the next message in that direction, as a connection that breaks would.
  void lose_next_to(const std::string& name);
  void lose_next_from(const std::string& name);

 private:
  struct State;
  std::shared_ptr<State> state_;  // owners: the wire and its ends
};

/// Messages of text.
inline std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }
inline std::string text_of(const Frame& frame) {
  return {reinterpret_cast<const char*>(frame.bytes().data()), frame.bytes().size()};
}

}  // namespace copepod::transport
