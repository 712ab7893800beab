#pragma once

#include <chrono>
#include <cstdint>

#include "observers/events.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

/// Reports how far a run is: first and last step always, in between about five times per second.
class Progress final : public Observer {
 public:
  /// @param events  must outlive this object
  Progress(Events& events, std::int64_t steps) : events_(events), steps_(steps) {}

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

 private:
  using Clock = std::chrono::steady_clock;
  void report(std::int64_t step, Clock::time_point now);

  Events& events_;
  std::int64_t steps_;
  std::int64_t first_step_ = -1;
  Clock::time_point started_;
  Clock::time_point reported_;
};

}  // namespace copepod::coupler
