#include "run/remote_components.hpp"

#include "remote/remote_solvers.hpp"

namespace copepod::coupler {

RemoteComponents::RemoteComponents(const Options& options, const ServicesCase& services,
                                   const std::atomic<int>& stop_signal) {
  settings_.connect_deadline_s = services.connect_deadline_s;
  settings_.progress_deadline_s = services.progress_deadline_s;
  settings_.endpoint = options.endpoint;
  settings_.session = options.session;
  settings_.key_file = options.key_file;
  settings_.wire_file = options.wire_file;
  settings_.stop_signal = &stop_signal;
}

void RemoteComponents::connect() {
  link_.emplace(settings_);
  link_->await_components();
}

std::unique_ptr<FluidSolver> RemoteComponents::make_fluid(const FluidSetup& setup, std::int64_t first_step) {
  return std::make_unique<RemoteFluid>(*link_, setup, first_step);
}

std::unique_ptr<BodySolver> RemoteComponents::make_body(const BodySetup& setup, std::int64_t first_step) {
  return std::make_unique<RemoteBody>(*link_, setup, first_step);
}

void RemoteComponents::stay_in_touch_during(const std::function<void()>& work) {
  link_->stay_in_touch_during(work);
}

void RemoteComponents::abort(const FailureReport& report) noexcept {
  if (link_) link_->abort(report);
}

}  // namespace copepod::coupler
