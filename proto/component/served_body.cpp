#include "component/served_body.hpp"

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

void require_finite(const Kinematics& kinematics, Eigen::Index bodies) {
  if (kinematics.bodies() != bodies) {
    throw SolverError("The body solver returned " + std::to_string(kinematics.bodies()) +
                          " bodies (there are " + std::to_string(bodies) + "). Fix step().",
                      0, kinematics.step);
  }
  using conversion::all_finite;
  if (all_finite(kinematics.position_m) && all_finite(kinematics.orientation_wxyz) &&
      all_finite(kinematics.velocity_m_per_s) && all_finite(kinematics.angular_velocity_rad_per_s))
    return;
  for (Eigen::Index body = 0; body < bodies; ++body) {
    const bool finite = kinematics.position_m.col(body).allFinite() &&
                        kinematics.orientation_wxyz.col(body).allFinite() &&
                        kinematics.velocity_m_per_s.col(body).allFinite() &&
                        kinematics.angular_velocity_rad_per_s.col(body).allFinite();
    if (finite) continue;
    throw SolverError("The state of body " + std::to_string(body) +
                          " is not a finite number (its motion has diverged). Use a smaller step.",
                      0, kinematics.step);
  }
}

}  // namespace

session::Configured ServedBody::make_solver(const conversion::Decoder& request) {
  BodySetup setup;
  request.read(setup);
  if (!setup.trace_directory.empty()) recording::timeline().open(setup.trace_directory, "body", 0);
  bodies_ = static_cast<Eigen::Index>(setup.bodies.size());
  solver_ = component_.make_solver(setup);
  session::Configured configured{solver_->driving_nodes()};
  driving_nodes_ = static_cast<Eigen::Index>(configured.driving_nodes.size());
  return configured;
}

void ServedBody::advance_bodies(const conversion::Decoder& request) {
  request.read(applied_, bodies_, driving_nodes_);
  {
    const recording::Span integrate("integrate");
    solver_->step(applied_, kinematics_);
  }
  require_finite(kinematics_, bodies_);
}

std::span<const std::byte> ServedBody::perform(Work work, const conversion::Decoder& request,
                                               const session::Header& header, conversion::Encoder& encoder) {
  switch (work) {
    case Work::make_solver:
      return encoder.encode(header, make_solver(request));
    case Work::tell_kinematics:
      solver_->kinematics(kinematics_);
      return encoder.encode(header, kinematics_);
    case Work::advance_bodies:
      advance_bodies(request);
      return encoder.encode(header, kinematics_);
    case Work::write_state:
      return encoder.encode(header, save(*solver_, request));
    case Work::read_state:
      solver_->restore(checkpoint_path(request));
      return encoder.encode(header, MessageKind::restored);
    case Work::tell_summary:
      return encoder.encode(header, solver_->summarise());
    default:
      throw std::logic_error("A body component was asked to " + std::string(name_of(work)) + ".");
  }
}

}  // namespace copepod::component
