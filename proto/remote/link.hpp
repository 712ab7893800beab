#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "contract/capabilities.hpp"
#include "contract/errors.hpp"

namespace copepod {

namespace remote {
class Exchange;
class Parties;
}  // namespace remote
namespace transport {
class Router;
}  // namespace transport

/// How the coupler reaches its components and how long it waits for them.
struct LinkSettings {
  std::string endpoint;                           ///< ipc:///… or tcp://…
  std::string session;                            ///< token that every component must show
  std::string key_file;                           ///< CURVE keys of the coupler; empty: none
  double connect_deadline_s = 60.0;               ///< for both Hellos
  double silence_s = 3.0;                         ///< no pong for so long: frozen or dead
  double progress_deadline_s = 60.0;              ///< pongs, but neither step, phase nor progress moves: hung
  std::string wire_file;                          ///< where to record every message; empty: nowhere
  const std::atomic<int>* stop_signal = nullptr;  ///< non-zero: waits throw Interrupted within 100 ms
};

/// The coupler's end of the wire to one fluid and one body component.
///
/// Legal call order:
///   construct  ->  await_components  ->  RemoteFluid, RemoteBody (they keep a reference)  ->  finish
///   stay_in_touch_during between any two of them; abort from anywhere.
///
/// Owned and used by one thread. While any call waits, the control lanes of both components are pinged, so a
/// component that dies while the coupler waits for the other one is noticed too. Errors that any waiting call
/// throws: PeerFailed (a component's own report), ComponentLost (died, froze or hung; names component, host,
/// rank, step), Interrupted (stop_signal).
class Link {
 public:
  /// Binds the endpoint.
  /// @throws Refused if another coupler that is alive holds the same ipc path, or the address cannot be
  /// bound; CaseError if the address needs keys or the key file cannot be used
  explicit Link(const LinkSettings& settings);
  /// The same over any other transport, for tests.
  Link(const LinkSettings& settings, std::unique_ptr<transport::Router> router);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  ~Link();

  /// Waits until a fluid and a body component have said Hello on both lanes and welcomes them.
  /// @throws DeadlinePassed naming who is missing, Refused if a component of ours speaks another protocol
  /// version
  void await_components();

  /// Legal after await_components.
  [[nodiscard]] const Capabilities& fluid_capabilities() const;
  [[nodiscard]] const Capabilities& body_capabilities() const;

  /// Does in another thread what takes the coupler long, and pings the components meanwhile; they would take
  /// a silent coupler for lost.
  /// @throws also what `work` throws; nothing is thrown before `work` is over
  void stay_in_touch_during(const std::function<void()>& work);

  /// Tells both components that the run is over and waits until they have said goodbye; they exit with 0.
  void finish();

  /// Tells every component that is still there why the run ends; never throws and never waits for an answer.
  void abort(const FailureReport& report) noexcept;

  /// For RemoteFluid and RemoteBody.
  [[nodiscard]] remote::Exchange& exchange() { return *exchange_; }

 private:
  double connect_deadline_s_;
  std::unique_ptr<transport::Router> router_;
  std::unique_ptr<remote::Parties> parties_;
  std::unique_ptr<remote::Exchange> exchange_;
};

}  // namespace copepod
