#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "config/load_case.hpp"
#include "contract/errors.hpp"
#include "run/components.hpp"
#include "run/events.hpp"
#include "run/run_directory.hpp"

namespace copepod::coupler {

/// Runs one case from connecting its components to the summary, and leaves a complete run directory.
class CaseRun {
 public:
  /// References must outlive this object.
  /// @param stop_signal  non-zero ends the run with Interrupted
  CaseRun(const LoadedCase& loaded, const RunDirectory& directory, Components& components, Events& events,
          const std::atomic<int>& stop_signal);

  /// @param on_connected  called once both components said who they are
  /// @throws what a component, the disk or a signal makes fail; the caller reports it
  void run(const std::function<void(const Capabilities& fluid, const Capabilities& body)>& on_connected);

  /// Step that was being computed; −1 before the first. Meaningful after a failure too.
  [[nodiscard]] std::int64_t step() const { return step_; }

 private:
  const LoadedCase& loaded_;
  const RunDirectory& directory_;
  Components& components_;
  Events& events_;
  const std::atomic<int>& stop_signal_;
  std::int64_t step_ = -1;
};

}  // namespace copepod::coupler
