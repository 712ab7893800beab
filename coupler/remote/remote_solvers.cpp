#include "remote/remote_solvers.hpp"

#include "contract/errors.hpp"

namespace copepod::coupler {

using conversion::Decoder;
using conversion::Encoder;
using session::Header;
using session::MessageKind;

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

}  // namespace

template <class Interface>
void RemoteSolver<Interface>::save(const std::string& path) {
  const MessageKind kind = MessageKind::save;
  const session::CheckpointPath target{path};
  session::Saved saved;
  link_.ask(number_, kind, next_step_, with(kind, target), into(saved));
  if (!saved.problem.empty()) throw StorageError(saved.problem);
}

template <class Interface>
void RemoteSolver<Interface>::restore(const std::string& path) {
  const MessageKind kind = MessageKind::restore;
  const session::CheckpointPath source{path};
  link_.ask(number_, kind, next_step_, with(kind, source), nothing);
}

template <class Interface>
SolverSummary RemoteSolver<Interface>::summarise() {
  const MessageKind kind = MessageKind::summarise;
  SolverSummary summary;
  link_.ask(number_, kind, next_step_, with(kind), into(summary));
  return summary;
}

template class RemoteSolver<FluidSolver>;
template class RemoteSolver<BodySolver>;
template class RemoteSolver<Controller>;

RemoteFluid::RemoteFluid(Link& link, const FluidSetup& setup, std::int64_t first_step)
    : RemoteSolver(link, kFluid, setup.loads(), first_step), flow_(setup.flow) {
  link_.ask(number_, MessageKind::fluid_setup, first_step, with(setup), nothing);
}

void RemoteFluid::exchange(const Kinematics& kinematics, Loads& loads) {
  link_.ask(number_, MessageKind::kinematics, kinematics.step, with(kinematics),
            into(loads, columns_, flow_.values_in(kinematics.step)));
  next_step_ = kinematics.step + 1;
}

RemoteBody::RemoteBody(Link& link, const BodySetup& setup, std::int64_t first_step)
    : RemoteSolver(link, kBody, setup.bodies.size(), first_step) {
  session::Configured configured;
  link_.ask(number_, MessageKind::body_setup, first_step, with(setup), into(configured));
  driving_nodes_ = configured.driving_nodes;
}

void RemoteBody::kinematics(Kinematics& kinematics) {
  const MessageKind kind = MessageKind::kinematics_request;
  link_.ask(number_, kind, next_step_, with(kind), into(kinematics, columns_));
}

void RemoteBody::step(const AppliedLoads& applied, Kinematics& next) {
  const std::int64_t step = applied.hydrodynamic.step;
  link_.ask(number_, MessageKind::applied_loads, step, with(applied), into(next, columns_));
  next_step_ = step + 1;
}

RemoteController::RemoteController(Link& link, std::size_t number, const ControllerSetup& setup,
                                   std::int64_t first_step)
    : RemoteSolver(link, number, setup.bodies.size(), first_step), action_(setup.actuators.size()) {
  link_.ask(number_, MessageKind::controller_setup, first_step, with(setup), nothing);
}

std::vector<double> RemoteController::act(const Observation& observation) {
  const std::int64_t step = observation.kinematics.step;
  link_.ask(number_, MessageKind::observation, step, with(observation), into(action_));
  next_step_ = step + 1;
  return action_;
}

RemoteComponents::RemoteComponents(const Options& options, const Case& the_case, std::function<int()> stop_signal)
    : settings_{.endpoint = options.endpoint,
                .session = options.session,
                .key_file = options.key_file,
                .connect_deadline_s = the_case.services.connect_deadline_s,
                .silence_s = the_case.services.silence_s,
                .progress_deadline_s = the_case.services.progress_deadline_s,
                .wire_file = options.wire_file,
                .controllers = {},
                .stop_signal = std::move(stop_signal)} {
  for (const ControllerCase& controller : the_case.controllers) settings_.controllers.push_back(controller.name);
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

std::unique_ptr<Controller> RemoteComponents::make_controller(std::size_t number, const ControllerSetup& setup,
                                                              std::int64_t first_step) {
  return std::make_unique<RemoteController>(*link_, kFirstController + number, setup, first_step);
}

}  // namespace copepod::coupler
