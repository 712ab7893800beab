#include "remote/remote_fluid.hpp"

#include "contract/errors.hpp"
#include "remote/exchange.hpp"

namespace copepod {

using conversion::Encoder;
using session::Header;
using session::MessageKind;
using session::Role;

RemoteFluid::RemoteFluid(Link& link, const FluidSetup& setup, std::int64_t first_step)
    : exchange_(link.exchange()),
      bodies_(static_cast<Eigen::Index>(setup.bodies.size())),
      next_step_(first_step) {
  exchange_.ask(Role::fluid, MessageKind::fluid_setup, first_step,
                [&](Encoder& encoder, const Header& header) { return encoder.encode(header, setup); });
}

void RemoteFluid::exchange(const Kinematics& kinematics, Loads& loads) {
  const conversion::Decoder& reply = exchange_.ask(
      Role::fluid, MessageKind::kinematics, kinematics.step,
      [&](Encoder& encoder, const Header& header) { return encoder.encode(header, kinematics); });
  reply.read(loads, bodies_);
  next_step_ = kinematics.step + 1;
}

void RemoteFluid::save(const std::string& path) {
  const conversion::Decoder& reply =
      exchange_.ask(Role::fluid, MessageKind::save, next_step_, [&](Encoder& encoder, const Header& header) {
        return encoder.encode(header, MessageKind::save, session::CheckpointPath{path});
      });
  session::Saved saved;
  reply.read(saved);
  if (!saved.problem.empty()) throw StorageError(saved.problem);
}

void RemoteFluid::restore(const std::string& path) {
  exchange_.ask(Role::fluid, MessageKind::restore, next_step_, [&](Encoder& encoder, const Header& header) {
    return encoder.encode(header, MessageKind::restore, session::CheckpointPath{path});
  });
}

SolverSummary RemoteFluid::summarise() {
  const conversion::Decoder& reply = exchange_.ask(
      Role::fluid, MessageKind::summarise, next_step_,
      [](Encoder& encoder, const Header& header) { return encoder.encode(header, MessageKind::summarise); });
  SolverSummary summary;
  reply.read(summary);
  return summary;
}

}  // namespace copepod
