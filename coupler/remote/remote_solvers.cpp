#include "remote/remote_solvers.hpp"

#include "contract/errors.hpp"

namespace copepod::coupler {

using conversion::Decoder;
using conversion::Encoder;
using session::Header;
using session::MessageKind;
using session::Role;

namespace {

/// Encodes a message with these fields; none for a message that has none.
template <class... Fields>
auto with(const Fields&... fields) {
  return [&](Encoder& encoder, const Header& header) { return encoder.encode(header, fields...); };
}

/// Reads the reply into `result`; `sizes` as for the Decoder.
template <class Result, class... Sizes>
auto into(Result& result, Sizes... sizes) {
  return [&result, sizes...](const Decoder& reply) { reply.read(result, sizes...); };
}

void nothing(const Decoder&) {}

// Requests that both roles answer alike.

void ask_to_save(Link& link, Role role, std::int64_t step, const std::string& path) {
  const MessageKind kind = MessageKind::save;
  const session::CheckpointPath target{path};
  session::Saved saved;
  link.ask(role, kind, step, with(kind, target), into(saved));
  if (!saved.problem.empty()) throw StorageError(saved.problem);
}

void ask_to_restore(Link& link, Role role, std::int64_t step, const std::string& path) {
  const MessageKind kind = MessageKind::restore;
  const session::CheckpointPath source{path};
  link.ask(role, kind, step, with(kind, source), nothing);
}

SolverSummary ask_for_summary(Link& link, Role role, std::int64_t step) {
  const MessageKind kind = MessageKind::summarise;
  SolverSummary summary;
  link.ask(role, kind, step, with(kind), into(summary));
  return summary;
}

}  // namespace

RemoteFluid::RemoteFluid(Link& link, const FluidSetup& setup, std::int64_t first_step)
    : link_(link), bodies_(static_cast<Eigen::Index>(setup.bodies.size())), next_step_(first_step) {
  link_.ask(Role::fluid, MessageKind::fluid_setup, first_step, with(setup), nothing);
}

void RemoteFluid::exchange(const Kinematics& kinematics, Loads& loads) {
  link_.ask(Role::fluid, MessageKind::kinematics, kinematics.step, with(kinematics), into(loads, bodies_));
  next_step_ = kinematics.step + 1;
}

void RemoteFluid::save(const std::string& path) { ask_to_save(link_, Role::fluid, next_step_, path); }
void RemoteFluid::restore(const std::string& path) { ask_to_restore(link_, Role::fluid, next_step_, path); }
SolverSummary RemoteFluid::summarise() { return ask_for_summary(link_, Role::fluid, next_step_); }

RemoteBody::RemoteBody(Link& link, const BodySetup& setup, std::int64_t first_step)
    : link_(link), bodies_(static_cast<Eigen::Index>(setup.bodies.size())), next_step_(first_step) {
  session::Configured configured;
  link_.ask(Role::body, MessageKind::body_setup, first_step, with(setup), into(configured));
  driving_nodes_ = configured.driving_nodes;
}

void RemoteBody::kinematics(Kinematics& kinematics) {
  const MessageKind kind = MessageKind::kinematics_request;
  link_.ask(Role::body, kind, next_step_, with(kind), into(kinematics, bodies_));
}

void RemoteBody::step(const AppliedLoads& applied, Kinematics& next) {
  const std::int64_t step = applied.hydrodynamic.step;
  link_.ask(Role::body, MessageKind::applied_loads, step, with(applied), into(next, bodies_));
  next_step_ = step + 1;
}

void RemoteBody::save(const std::string& path) { ask_to_save(link_, Role::body, next_step_, path); }
void RemoteBody::restore(const std::string& path) { ask_to_restore(link_, Role::body, next_step_, path); }
SolverSummary RemoteBody::summarise() { return ask_for_summary(link_, Role::body, next_step_); }

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

void RemoteComponents::stay_in_touch_during(const std::function<void()>& work) { link_->stay_in_touch_during(work); }

void RemoteComponents::abort(const FailureReport& report) noexcept {
  if (link_) link_->abort(report);
}

}  // namespace copepod::coupler
