#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "disturbance.hpp"

namespace copepod::chaos {

/// Stands between one component and the coupler and disturbs what passes in both directions, on both lanes.
///
///   component (DEALER) ──► ROUTER [proxy] DEALER, one per lane ──► coupler (ROUTER)
///
/// Lives in a thread of its own until it is destroyed.
class ChaosProxy {
 public:
  /// @param coupler  endpoint of the coupler
  /// @param folder   for the sockets of the proxy
  ChaosProxy(const std::string& coupler, const std::string& folder, const std::string& name, const ChaosPlan& plan);
  ChaosProxy(const ChaosProxy&) = delete;
  ChaosProxy& operator=(const ChaosProxy&) = delete;
  ~ChaosProxy();

  /// Where the component connects.
  [[nodiscard]] std::string endpoint() const;

  /// Messages that passed, and how many of them met which fate; to be read after `stop`.
  [[nodiscard]] const std::map<Disturbance, std::int64_t>& counts() const;

  /// Ends the thread; nothing passes any more.
  void stop();

 private:
  class Relay;
  std::unique_ptr<Relay> relay_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace copepod::chaos
