#include "observers/progress.hpp"

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

void Progress::finish(const StepRecord& last) { report(last.step, Clock::now()); }

void Progress::report(std::int64_t step, Clock::time_point now) {
  reported_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - started_).count();
  const auto done = static_cast<double>(step - first_step_);
  const double steps_per_s = elapsed_s > 0.0 ? done / elapsed_s : 0.0;
  const auto left = static_cast<double>(steps_ - step);
  events_.progress(step, steps_, steps_per_s, steps_per_s > 0.0 ? left / steps_per_s : 0.0);
}

}  // namespace copepod::coupler
