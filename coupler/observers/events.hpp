#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include <nlohmann/json.hpp>

#include "contract/errors.hpp"
#include "observers/observer.hpp"
#include "system/process.hpp"

namespace copepod::coupler {

/// Reports to the deploy command what happens: one JSON object per line, each flushed.
class Events {
 public:
  /// @param stream  must outlive this object
  explicit Events(std::ostream& stream) : stream_(stream) {}

  /// @param phase  starting, handshake, configuring, running, checkpointing or finishing
  void phase(const std::string& phase) { write({{"event", "phase"}, {"phase", phase}}); }
  void progress(std::int64_t step, std::int64_t steps, double steps_per_s, double remaining_s) {
    write({{"event", "progress"},
           {"step", step},
           {"steps", steps},
           {"steps_per_s", steps_per_s},
           {"remaining_s", remaining_s}});
  }
  void failure(const FailureReport& report) {
    write({{"event", "failure"},
           {"code", static_cast<int>(report.code)},
           {"component", report.component},
           {"host", report.host},
           {"rank", report.rank},
           {"step", report.step},
           {"reason", report.reason}});
  }
  void finished(const std::string& summary_path) { write({{"event", "finished"}, {"summary", summary_path}}); }
  /// Something worth a line that does not end the run.
  void notice(const std::string& text) { write({{"event", "notice"}, {"text", text}}); }

 private:
  void write(const nlohmann::ordered_json& event) {
    // A reason may contain bytes of a peer that are not UTF-8; they must not end the coupler.
    stream_ << event.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n' << std::flush;
  }

  std::ostream& stream_;
};

/// Reports how far a run is: first and last step always, in between about five times per second.
class Progress final : public Observer {
 public:
  /// @param events  must outlive this object
  Progress(Events& events, std::int64_t steps) : events_(events), steps_(steps) {}

  void observe(const StepRecord& record) override {
    const double at_s = now_s();
    if (first_step_ < 0) {
      first_step_ = record.step;
      started_s_ = at_s;
    } else if (at_s - reported_s_ < 0.2) {
      return;
    }
    report(record.step, at_s);
  }
  void finish(const StepRecord& last) override { report(last.step, now_s()); }

 private:
  void report(std::int64_t step, double at_s) {
    reported_s_ = at_s;
    const double elapsed_s = at_s - started_s_;
    const auto done = static_cast<double>(step - first_step_);
    const double steps_per_s = elapsed_s > 0.0 ? done / elapsed_s : 0.0;
    const auto left = static_cast<double>(steps_ - step);
    events_.progress(step, steps_, steps_per_s, steps_per_s > 0.0 ? left / steps_per_s : 0.0);
  }

  Events& events_;
  std::int64_t steps_;
  std::int64_t first_step_ = -1;
  double started_s_ = 0.0;
  double reported_s_ = 0.0;
};

}  // namespace copepod::coupler
