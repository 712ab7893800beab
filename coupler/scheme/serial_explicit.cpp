#include "scheme/serial_explicit.hpp"

#include <string>
#include <utility>

#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

bool has_bodies(const Loads& loads, Eigen::Index bodies) {
  return loads.force_N.cols() == bodies && loads.torque_N_m.cols() == bodies;
}

bool has_bodies(const Kinematics& kinematics, Eigen::Index bodies) {
  return kinematics.position_m.cols() == bodies && kinematics.orientation_wxyz.cols() == bodies &&
         kinematics.velocity_m_per_s.cols() == bodies && kinematics.angular_velocity_rad_per_s.cols() == bodies;
}

}  // namespace

void LoadAverage::apply(const Loads& raw, Loads& applied) {
  if (kind_ == LoadAveraging::none) {
    applied = raw;
    return;
  }
  if (previous_.bodies() != raw.bodies()) {
    previous_.resize(raw.bodies());
    previous_.force_N.setZero();
    previous_.torque_N_m.setZero();
  }
  applied.step = raw.step;
  applied.force_N = 0.5 * (raw.force_N + previous_.force_N);
  applied.torque_N_m = 0.5 * (raw.torque_N_m + previous_.torque_N_m);
  for (const Eigen::Index body : not_averaged_) {
    applied.force_N.col(body) = raw.force_N.col(body);
    applied.torque_N_m.col(body) = raw.torque_N_m.col(body);
  }
  previous_ = raw;
}

SerialExplicit::SerialExplicit(FluidSolver& fluid, BodySolver& body, const DrivingProtocol& driving,
                               const Plausibility& plausibility, LoadAveraging averaging, Observer& observer,
                               Timeline& timeline, VirtualMass virtual_mass, Lubrication lubrication)
    : fluid_(fluid),
      body_(body),
      driving_(driving),
      plausibility_(plausibility),
      averaging_(averaging, virtual_mass.not_averaged()),
      virtual_mass_(std::move(virtual_mass)),
      lubrication_(std::move(lubrication)),
      observer_(observer),
      timeline_(timeline),
      nodes_(body.driving_nodes()) {
  body_.kinematics(kinematics_);
  step_ = kinematics_.step;
}

void SerialExplicit::run(std::int64_t stop, const std::function<bool(std::int64_t)>& pause) {
  while (step_ < stop && !pause(step_)) {
    timeline_.set_step(step_);
    // Map the bodies to the lattice; hydrodynamic forces on them.
    fluid_watch_.time([&] { fluid_.exchange(kinematics_, loads_); });
    couple_watch_.time([&] { couple(); });

    // Time step of the rigid bodies; meanwhile a fluid service streams and collides.
    body_watch_.time([&] { body_.step(applied_, next_); });
    plausibility_.judge(kinematics_, next_);
    fluid_watch_.time([&] { fluid_.advance(); });

    std::swap(kinematics_, next_);
    ++step_;
  }
}

void SerialExplicit::restore(std::int64_t step, const Loads& previous_loads, const Kinematics& previous_kinematics) {
  const auto require = [](bool fits, const char* what) {
    if (!fits) throw StorageError(std::string("the checkpoint cannot be resumed (") + what + "). Use another one.");
  };
  const auto is_before = [&](const auto& previous, bool is_needed) {
    const Eigen::Index bodies = is_needed ? kinematics_.bodies() : 0;
    return has_bodies(previous, bodies) && (bodies == 0 || previous.step == step_ - 1);
  };
  require(step == step_, "its bodies are at another step than the coupler");
  require(is_before(previous_loads, averaging_.averages()), "its loads are not those of all bodies in the step before");
  require(is_before(previous_kinematics, virtual_mass_.remembers()),
          "its kinematics are not those of all bodies in the step before");
  averaging_.restore(previous_loads);
  virtual_mass_.restore(previous_kinematics);
}

/// Loads to apply, and the drive.
void SerialExplicit::couple() {
  averaging_.apply(loads_, averaged_);
  driving_.sample(step_, nodes_, applied_.actuation);
  driving_.loads(kinematics_, applied_.actuation, drive_);
  applied_.hydrodynamic = averaged_;
  virtual_mass_.add_to(applied_.hydrodynamic, kinematics_);
  if (const Loads* films = lubrication_.loads(kinematics_, applied_.hydrodynamic, drive_)) {
    for (Loads* loads : {&loads_, &averaged_, &applied_.hydrodynamic}) {
      loads->force_N += films->force_N;
      loads->torque_N_m += films->torque_N_m;
    }
  }
  observer_.observe({step_, kinematics_, loads_, averaged_, drive_});
}

void SerialExplicit::finish() { observer_.finish({step_, kinematics_, loads_, averaged_, drive_}); }

}  // namespace copepod::coupler
