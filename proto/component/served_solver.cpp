#include <stdexcept>
#include <string>

#include "component/server.hpp"
#include "contract/errors.hpp"
#include "conversion/finite.hpp"
#include "recording/recorder.hpp"

namespace copepod::component {

using session::MessageKind;
using session::Work;

namespace {

/// The path in a Save or Restore.
std::string checkpoint_path(const conversion::Decoder& request) {
  session::CheckpointPath path;
  request.read(path);
  return path.path;
}

/// Lets a solver write its state. A full disk does not end the run: the solver is unchanged.
/// @throws what else the solver throws
session::Saved save(Solver& solver, const conversion::Decoder& request) {
  try {
    solver.save(checkpoint_path(request));
    return {};
  } catch (const StorageError& error) {
    return {error.what()};
  }
}

/// Lets a solver read its state. Whatever a damaged one makes of it, the run ends with the code of storage.
void read_state(Solver& solver, const std::string& path) {
  try {
    solver.restore(path);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw StorageError("The solver cannot read the state in " + path + " (" + error.what() +
                       "). Resume from another checkpoint.");
  }
}

/// Loads that are not finite would only be noticed by the bodies, who are not to blame.
/// @param of      "The load on", before the body
/// @param remedy  "has diverged). What to do."
void require_finite(std::int64_t step, Eigen::Index bodies, const std::string& of, const std::string& remedy,
                    const auto&... of_bodies) {
  if ((conversion::all_finite(of_bodies) && ...)) return;
  for (Eigen::Index body = 0; body < bodies; ++body) {
    if ((of_bodies.col(body).allFinite() && ...)) continue;
    throw SolverError(of + " body " + std::to_string(body) + " is not a finite number (" + remedy, 0, step);
  }
}

void require_finite(const Loads& loads, Eigen::Index bodies) {
  if (loads.force_N.cols() != bodies || loads.torque_N_m.cols() != bodies)
    throw SolverError("The fluid solver returned loads on " + std::to_string(loads.bodies()) + " bodies (there are " +
                          std::to_string(bodies) + "). Fix exchange().",
                      0, loads.step);
  require_finite(loads.step, bodies, "The load on", "the flow has diverged). Use a smaller step or a larger viscosity.",
                 loads.force_N, loads.torque_N_m);
}

void require_finite(const Kinematics& kinematics, Eigen::Index bodies) {
  if (kinematics.bodies() != bodies)
    throw SolverError("The body solver returned " + std::to_string(kinematics.bodies()) + " bodies (there are " +
                          std::to_string(bodies) + "). Fix step().",
                      0, kinematics.step);
  require_finite(kinematics.step, bodies, "The state of", "its motion has diverged). Use a smaller step.",
                 kinematics.position_m, kinematics.orientation_wxyz, kinematics.velocity_m_per_s,
                 kinematics.angular_velocity_rad_per_s);
}

/// The session's table leaves no such work to this role.
std::logic_error not_asked(const std::string& role, Work work) {
  return std::logic_error("A " + role + " was asked to " + std::string(name_of(work)) + ".");
}

/// Of the process in a recording.
std::string trace_name(const FluidSetup&) { return "fluid"; }
std::string trace_name(const BodySetup&) { return "body"; }
std::string trace_name(const ControllerSetup& setup) { return setup.name; }

}  // namespace

template <class Setup, class Solver>
conversion::Bytes Served<Setup, Solver>::perform(const Request& request) {
  const auto& [work, message, header, encoder] = request;
  switch (work) {
    case Work::make_solver: {
      Setup setup;
      message.read(setup);
      if (!setup.trace_directory.empty())
        recording::open_timeline(context_.timeline(), setup.trace_directory, trace_name(setup), 0);
      bodies_ = static_cast<Eigen::Index>(setup.bodies.size());
      solver_.reset();  // one at a time fits into the memory
      solver_ = component_.make_solver(setup, context_);
      return encoder.encode(header, configured(setup));
    }
    case Work::write_state:
      return encoder.encode(header, save(*solver_, message));
    case Work::read_state:
      read_state(*solver_, checkpoint_path(message));
      return encoder.encode(header, MessageKind::restored);
    case Work::send_summary:
      return encoder.encode(header, solver_->summarise());
    default:
      return exchange(request);
  }
}

template class Served<FluidSetup, FluidSolver>;
template class Served<BodySetup, BodySolver>;
template class Served<ControllerSetup, Controller>;

session::Configured ServedFluid::configured(const FluidSetup& setup) {
  columns_ = setup.loads();
  flow_ = setup.flow;
  return {};
}

conversion::Bytes ServedFluid::exchange(const Request& request) {
  if (request.work != Work::compute_loads) throw not_asked("fluid", request.work);
  request.message.read(kinematics_, bodies_);
  solver_->exchange(kinematics_, loads_);
  require_finite(loads_, columns_);
  if (const Eigen::Index due = flow_.values_in(kinematics_.step); loads_.flow.size() != due)
    throw SolverError("The fluid solver returned " + std::to_string(loads_.flow.size()) +
                          " values of the flow (the setup asks for " + std::to_string(due) + "). Fix exchange().",
                      0, loads_.step);
  return request.encoder.encode(request.header, loads_);
}

session::Configured ServedController::configured(const ControllerSetup& setup) {
  actuators_ = setup.actuators.size();
  flow_ = std::ssize(setup.flow);
  return {};
}

conversion::Bytes ServedController::exchange(const Request& request) {
  if (request.work != Work::decide) throw not_asked("controller", request.work);
  request.message.read(observation_, bodies_, flow_);
  const Span decide(context_.timeline(), "decide");
  const std::vector<double> action = solver_->act(observation_);
  if (action.size() != actuators_ || !conversion::all_finite(action.data(), action.size()))
    throw SolverError("The controller returned " + std::to_string(action.size()) +
                          " values, or one that is not finite " + "(its actuators are " + std::to_string(actuators_) +
                          "). Fix act().",
                      0, request.header.step);
  return request.encoder.encode(request.header, action);
}

session::Configured ServedBody::configured(const BodySetup& setup) {
  actuators_ = static_cast<Eigen::Index>(setup.actuators.size());
  session::Configured configured{solver_->driving_nodes()};
  driving_nodes_ = static_cast<Eigen::Index>(configured.driving_nodes.size());
  return configured;
}

conversion::Bytes ServedBody::exchange(const Request& request) {
  if (request.work == Work::send_kinematics) {
    solver_->kinematics(kinematics_);
  } else if (request.work == Work::advance_bodies) {
    request.message.read(applied_, bodies_, actuators_, driving_nodes_);
    {
      const Span integrate(context_.timeline(), "integrate");
      solver_->step(applied_, kinematics_);
    }
    require_finite(kinematics_, bodies_);
  } else {
    throw not_asked("body component", request.work);
  }
  return request.encoder.encode(request.header, kinematics_);
}

}  // namespace copepod::component
