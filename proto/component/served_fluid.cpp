#include "component/served_fluid.hpp"

#include <stdexcept>
#include <string>

#include "component/checkpoint_request.hpp"
#include "contract/errors.hpp"
#include "conversion/finite.hpp"
#include "recording/timeline.hpp"

namespace copepod::component {

using session::MessageKind;
using session::Work;

namespace {

/// Loads that are not finite would only be noticed by the bodies, who are not to blame.
void require_finite(const Loads& loads, Eigen::Index bodies) {
  if (loads.force_N.cols() != bodies || loads.torque_N_m.cols() != bodies) {
    throw SolverError("The fluid solver returned loads on " + std::to_string(loads.bodies()) +
                          " bodies (there are " + std::to_string(bodies) + "). Fix exchange().",
                      0, loads.step);
  }
  if (conversion::all_finite(loads.force_N) && conversion::all_finite(loads.torque_N_m)) return;
  for (Eigen::Index body = 0; body < bodies; ++body) {
    if (loads.force_N.col(body).allFinite() && loads.torque_N_m.col(body).allFinite()) continue;
    throw SolverError(
        "The load on body " + std::to_string(body) +
            " is not a finite number (the flow has diverged). Use a smaller step or a larger viscosity.",
        0, loads.step);
  }
}

}  // namespace

void ServedFluid::make_solver(const conversion::Decoder& request) {
  FluidSetup setup;
  request.read(setup);
  if (!setup.trace_directory.empty()) recording::timeline().open(setup.trace_directory, "fluid", 0);
  bodies_ = static_cast<Eigen::Index>(setup.bodies.size());
  solver_ = component_.make_solver(setup);
}

void ServedFluid::compute_loads(const conversion::Decoder& request) {
  request.read(kinematics_, bodies_);
  solver_->exchange(kinematics_, loads_);
  require_finite(loads_, bodies_);
}

std::span<const std::byte> ServedFluid::perform(Work work, const conversion::Decoder& request,
                                                const session::Header& header, conversion::Encoder& encoder) {
  switch (work) {
    case Work::make_solver:
      make_solver(request);
      return encoder.encode(header, session::Configured{});
    case Work::compute_loads:
      compute_loads(request);
      return encoder.encode(header, loads_);
    case Work::write_state:
      return encoder.encode(header, save(*solver_, request));
    case Work::read_state:
      solver_->restore(checkpoint_path(request));
      return encoder.encode(header, MessageKind::restored);
    case Work::tell_summary:
      return encoder.encode(header, solver_->summarise());
    default:
      throw std::logic_error("A fluid was asked to " + std::string(name_of(work)) + ".");
  }
}

void ServedFluid::follow_up(Work work) {
  if (work == Work::compute_loads) solver_->advance();
}

}  // namespace copepod::component
