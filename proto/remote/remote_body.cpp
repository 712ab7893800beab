#include "remote/remote_body.hpp"

#include "contract/errors.hpp"
#include "remote/exchange.hpp"

namespace copepod {

using conversion::Encoder;
using session::Header;
using session::MessageKind;
using session::Role;

RemoteBody::RemoteBody(Link& link, const BodySetup& setup, std::int64_t first_step)
    : exchange_(link.exchange()),
      bodies_(static_cast<Eigen::Index>(setup.bodies.size())),
      next_step_(first_step) {
  const conversion::Decoder& reply =
      exchange_.ask(Role::body, MessageKind::body_setup, first_step,
                    [&](Encoder& encoder, const Header& header) { return encoder.encode(header, setup); });
  session::Configured configured;
  reply.read(configured);
  driving_nodes_ = configured.driving_nodes;
}

void RemoteBody::kinematics(Kinematics& kinematics) {
  const conversion::Decoder& reply = exchange_.ask(
      Role::body, MessageKind::kinematics_request, next_step_, [](Encoder& encoder, const Header& header) {
        return encoder.encode(header, MessageKind::kinematics_request);
      });
  reply.read(kinematics, bodies_);
}

void RemoteBody::step(const AppliedLoads& applied, Kinematics& next) {
  const std::int64_t step = applied.hydrodynamic.step;
  const conversion::Decoder& reply =
      exchange_.ask(Role::body, MessageKind::applied_loads, step,
                    [&](Encoder& encoder, const Header& header) { return encoder.encode(header, applied); });
  reply.read(next, bodies_);
  next_step_ = step + 1;
}

void RemoteBody::save(const std::string& path) {
  const conversion::Decoder& reply =
      exchange_.ask(Role::body, MessageKind::save, next_step_, [&](Encoder& encoder, const Header& header) {
        return encoder.encode(header, MessageKind::save, session::CheckpointPath{path});
      });
  session::Saved saved;
  reply.read(saved);
  if (!saved.problem.empty()) throw StorageError(saved.problem);
}

void RemoteBody::restore(const std::string& path) {
  exchange_.ask(Role::body, MessageKind::restore, next_step_, [&](Encoder& encoder, const Header& header) {
    return encoder.encode(header, MessageKind::restore, session::CheckpointPath{path});
  });
}

SolverSummary RemoteBody::summarise() {
  const conversion::Decoder& reply = exchange_.ask(
      Role::body, MessageKind::summarise, next_step_,
      [](Encoder& encoder, const Header& header) { return encoder.encode(header, MessageKind::summarise); });
  SolverSummary summary;
  reply.read(summary);
  return summary;
}

}  // namespace copepod
