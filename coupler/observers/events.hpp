#pragma once

#include <chrono>
#include <cstdint>
#include <ostream>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "contract/errors.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

/// Reports to the deploy command what happens: one JSON object per line, each flushed.
class Events {
 public:
  /// @param stream  must outlive this object
  explicit Events(std::ostream& stream) : stream_(stream) {}

  /// @param phase  starting, handshake, configuring, running, checkpointing or finishing
  void phase(const std::string& phase);
  void progress(std::int64_t step, std::int64_t steps, double steps_per_s, double remaining_s);
  void failure(const FailureReport& report);
  void finished(const std::string& summary_path);
  void notice(const std::string& text);  ///< something worth a line that does not end the run

 private:
  void write(const nlohmann::ordered_json& event);
  std::ostream& stream_;
};

/// Reports how far a run is: first and last step always, in between about five times per second.
class Progress final : public Observer {
 public:
  /// @param events  must outlive this object
  Progress(Events& events, std::int64_t steps) : events_(events), steps_(steps) {}

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override { report(last.step, Clock::now()); }

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
