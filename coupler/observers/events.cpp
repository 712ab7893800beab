#include "observers/events.hpp"

#include <nlohmann/json.hpp>

namespace copepod::coupler {

void Progress::observe(const StepRecord& record) {
  const Clock::time_point now = Clock::now();
  if (first_step_ < 0) {
    first_step_ = record.step;
    started_ = now;
  } else if (now - reported_ < std::chrono::milliseconds(200)) {
    return;
  }
  report(record.step, now);
}

void Progress::report(std::int64_t step, Clock::time_point now) {
  reported_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - started_).count();
  const auto done = static_cast<double>(step - first_step_);
  const double steps_per_s = elapsed_s > 0.0 ? done / elapsed_s : 0.0;
  const auto left = static_cast<double>(steps_ - step);
  events_.progress(step, steps_, steps_per_s, steps_per_s > 0.0 ? left / steps_per_s : 0.0);
}

void Events::phase(const std::string& phase) { write({{"event", "phase"}, {"phase", phase}}); }

void Events::progress(std::int64_t step, std::int64_t steps, double steps_per_s, double remaining_s) {
  write({{"event", "progress"},
         {"step", step},
         {"steps", steps},
         {"steps_per_s", steps_per_s},
         {"remaining_s", remaining_s}});
}

void Events::failure(const FailureReport& report) {
  write({{"event", "failure"},
         {"code", static_cast<int>(report.code)},
         {"component", report.component},
         {"host", report.host},
         {"rank", report.rank},
         {"step", report.step},
         {"reason", report.reason}});
}

void Events::finished(const std::string& summary_path) { write({{"event", "finished"}, {"summary", summary_path}}); }

void Events::notice(const std::string& text) { write({{"event", "notice"}, {"text", text}}); }

void Events::write(const nlohmann::ordered_json& event) {
  // A reason may contain bytes of a peer that are not UTF-8; they must not end the coupler.
  stream_ << event.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n' << std::flush;
}

}  // namespace copepod::coupler
