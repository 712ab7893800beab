#include "scheme/serial_explicit.hpp"

#include <cmath>
#include <string>

#include <spdlog/spdlog.h>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {

namespace {

/// h = R J Rᵀ ω
Eigen::Vector3d angular_momentum(const Eigen::Matrix3d& inertia_kg_m2, const Kinematics& kinematics,
                                 Eigen::Index body) {
  const Eigen::Vector3d w_WB = kinematics.angular_velocity_rad_per_s.col(body);
  if (inertia_kg_m2 == inertia_kg_m2(0, 0) * Eigen::Matrix3d::Identity())  // commutes with every rotation
    return inertia_kg_m2(0, 0) * w_WB;
  const Eigen::Matrix3d R_WB = rotation_matrix(kinematics.orientation_wxyz.col(body));
  return R_WB * (inertia_kg_m2 * (R_WB.transpose() * w_WB));
}

constexpr std::array axes{"x", "y", "z"};
constexpr double quaternion_tolerance = 1e-3;
constexpr double largest_turn_rad = 1.0;  // the surface then moves by a radius

[[noreturn]] void fail(const BodySpecification& body, std::int64_t step, const std::string& found) {
  throw PeerFailed({ExitCode::solver_failed, "body", "", 0, step,
                    "In step " + std::to_string(step) + " body '" + body.name + "' " + found +
                        ". Use a smaller step, smaller forces, coupling.virtual_mass: auto for light bodies, or check "
                        "the body component."});
}

bool has_bodies(const Loads& loads, Eigen::Index bodies) {
  return loads.force_N.cols() == bodies && loads.torque_N_m.cols() == bodies;
}

bool has_bodies(const Kinematics& kinematics, Eigen::Index bodies) {
  return kinematics.position_m.cols() == bodies && kinematics.orientation_wxyz.cols() == bodies &&
         kinematics.velocity_m_per_s.cols() == bodies && kinematics.angular_velocity_rad_per_s.cols() == bodies;
}

}  // namespace

VirtualMass::VirtualMass(const BodySetup& setup, const std::vector<double>& mass_kg, LoadAveraging averaging,
                         bool returns)
    : step_s_(setup.step_s), returns_(returns) {
  for (std::size_t body = 0; body < mass_kg.size(); ++body) {
    if (!(mass_kg[body] > 0.0)) continue;
    additions_.push_back({static_cast<Eigen::Index>(body), mass_kg[body],
                          inertia_tensor_kg_m2(setup.bodies[body].shape, mass_kg[body]),
                          mass_kg[body] * setup.gravity_m_per_s2});
    if (averaging == LoadAveraging::none) not_averaged_.push_back(additions_.back().body);
  }
}

BodySetup VirtualMass::enlarged(BodySetup setup) const {
  for (const Addition& addition : additions_) {
    BodySpecification& body = setup.bodies[addition.body];
    body.mass_kg += addition.mass_kg;
    if (body.inertia_kg_m2.empty()) continue;
    const Eigen::Matrix3d& J = addition.inertia_kg_m2;
    const std::array added{J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2)};
    for (std::size_t i = 0; i < added.size(); ++i) body.inertia_kg_m2[i] += added[i];
  }
  return setup;
}

void VirtualMass::add_to(Loads& loads, const Kinematics& kinematics) {
  if (!returns_) {
    for (const Addition& addition : additions_) loads.force_N.col(addition.body) -= addition.weight_N;
    return;
  }
  if (additions_.empty()) return;
  if (previous_.bodies() != kinematics.bodies()) previous_ = kinematics;
  for (const auto& [body, mass_kg, inertia_kg_m2, weight_N] : additions_) {
    const Eigen::Vector3d gained_m_per_s = kinematics.velocity_m_per_s.col(body) - previous_.velocity_m_per_s.col(body);
    loads.force_N.col(body) += mass_kg / step_s_ * gained_m_per_s - weight_N;
    loads.torque_N_m.col(body) +=
        (angular_momentum(inertia_kg_m2, kinematics, body) - angular_momentum(inertia_kg_m2, previous_, body)) /
        step_s_;
  }
  previous_ = kinematics;
}

Plausibility::Plausibility(const FluidSetup& fluid, const std::vector<BodySpecification>& bodies,
                           double largest_speed_m_per_s)
    : bodies_(bodies),
      largest_speed_m_per_s_(largest_speed_m_per_s),
      length_m_(fluid.length_m()),
      boundaries_(fluid.boundaries) {
  confined_.resize(bodies.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    periodic_[axis] = length_m_[axis] > 0.0 && fluid.boundaries[2 * axis].kind == BoundaryKind::periodic;
    if (periodic_[axis]) continue;
    for (std::size_t body = 0; body < bodies.size(); ++body) {
      const double at = bodies[body].position_m[axis];
      confined_[body][axis] = length_m_[axis] > 0.0 && at >= 0.0 && at <= length_m_[axis];
    }
  }
}

bool Plausibility::is_removed(const Eigen::Vector3d& position_m) const {
  for (std::size_t face = 0; face < boundaries_.size(); ++face) {
    if (!boundaries_[face].removes_bodies) continue;
    const auto axis = static_cast<Eigen::Index>(face / 2);
    const double beyond_m = face % 2 == 1 ? position_m[axis] - length_m_[axis] : -position_m[axis];
    if (beyond_m > 0.0) return position_m.allFinite();
  }
  return false;
}

void Plausibility::judge(const Kinematics& before, const Kinematics& after) const {
  if (after.bodies() != static_cast<Eigen::Index>(bodies_.size())) {
    throw PeerFailed({ExitCode::solver_failed, "body", "", 0, before.step,
                      "The body component returned " + std::to_string(after.bodies()) + " bodies in step " +
                          std::to_string(before.step) + " (the case has " + std::to_string(bodies_.size()) +
                          "). Fix its step()."});
  }
  // Written so that a comparison with NaN fails.
  for (Eigen::Index column = 0; column < after.bodies(); ++column) {
    const BodySpecification& body = bodies_[column];
    if (is_removed(after.position_m.col(column))) {
      if (!is_removed(before.position_m.col(column)))
        spdlog::info("body '{}' left through an outflow in step {}", body.name, before.step);
      continue;
    }
    const double norm = after.orientation_wxyz.col(column).norm();
    if (!(std::abs(norm - 1.0) <= quaternion_tolerance)) {
      fail(body, before.step,
           "got an orientation of length " + rounded_text(norm) + " (an orientation is a quaternion of length 1)");
    }
    Eigen::Vector3d moved = after.position_m.col(column) - before.position_m.col(column);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double at = after.position_m(axis, column);
      if (periodic_[axis]) {  // a component may fold positions back into the domain
        moved[axis] -= length_m_[axis] * std::round(moved[axis] / length_m_[axis]);
      } else if (confined_[column][axis] && !(at >= 0.0 && at <= length_m_[axis])) {
        fail(body, before.step,
             std::string("left the domain: ") + axes[axis] + " = " + length_text(at) + " (the domain ends at 0 and " +
                 length_text(length_m_[axis]) + ")");
      }
    }
    const double distance = moved.norm();
    if (!(distance <= body.shape.radius_m)) {
      fail(body, before.step,
           "moved by " + length_text(distance) + " (more than its radius of " + length_text(body.shape.radius_m) + ")");
    }
    const double half_turn = std::abs(after.orientation_wxyz.col(column).dot(before.orientation_wxyz.col(column)));
    if (!(half_turn >= std::cos(0.5 * largest_turn_rad) * (1.0 - 2.0 * quaternion_tolerance)))
      fail(body, before.step, "turned by more than one radian");
    const double speed_m_per_s = after.velocity_m_per_s.col(column).norm() +
                                 after.angular_velocity_rad_per_s.col(column).norm() * bounding_radius_m(body.shape);
    if (!(speed_m_per_s <= largest_speed_m_per_s_) || !std::isfinite(speed_m_per_s)) {
      fail(body, before.step,
           "has a surface that moves at " + rounded_text(speed_m_per_s) + " m/s (the fluid follows up to " +
               rounded_text(largest_speed_m_per_s_) + " m/s: the coupling has diverged)");
    }
  }
}

void LoadAverage::apply(const Loads& raw, Loads& applied) {
  if (kind_ == LoadAveraging::none) {
    applied = raw;
    return;
  }
  if (previous_.bodies() != raw.bodies()) {
    previous_.force_N.setZero(3, raw.bodies());
    previous_.torque_N_m.setZero(3, raw.bodies());
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
                               Timeline& timeline, VirtualMass virtual_mass, Lubrication lubrication,
                               Controllers controllers)
    : fluid_(fluid),
      body_(body),
      driving_(driving),
      plausibility_(plausibility),
      averaging_(averaging, virtual_mass.not_averaged()),
      virtual_mass_(std::move(virtual_mass)),
      lubrication_(std::move(lubrication)),
      controllers_(std::move(controllers)),
      observer_(observer),
      timeline_(timeline),
      nodes_(body.driving_nodes()) {
  body_.kinematics(kinematics_);
  step_ = kinematics_.step;
  loads_.force_N.setZero(3, kinematics_.bodies());
  loads_.torque_N_m.setZero(3, kinematics_.bodies());
  averaged_ = drive_ = loads_;  // of a run that ends before its first step
}

void SerialExplicit::run(std::int64_t stop, const std::function<bool(std::int64_t)>& pause) {
  while (step_ < stop && !pause(step_)) {
    timeline_.set_step(step_);
    controllers_.act(kinematics_, loads_);
    // Map the bodies to the lattice; hydrodynamic forces on them.
    fluid_watch_.time([&] { fluid_.exchange(kinematics_, loads_); });
    split_loads();
    couple_watch_.time([&] { couple(); });

    // Time step of the rigid bodies; meanwhile a fluid service streams and collides.
    body_watch_.time([&] { body_.step(applied_, next_); });
    plausibility_.judge(kinematics_, next_);
    fluid_watch_.time([&] { fluid_.advance(); });

    std::swap(kinematics_, next_);
    ++step_;
  }
}

void SerialExplicit::restore(std::int64_t step, const Loads& previous_loads, const Kinematics& previous_kinematics,
                             const Loads& loads) {
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
  if (has_bodies(loads, kinematics_.bodies())) loads_ = loads;
  flow_ = loads_.flow;
  averaging_.restore(previous_loads);
  virtual_mass_.restore(previous_kinematics);
}

/// Loads on obstacles come behind those on the bodies. The newest sample of the flow stays.
void SerialExplicit::split_loads() {
  if (loads_.flow.size() == 0) loads_.flow = flow_;
  flow_ = loads_.flow;
  const Eigen::Index bodies = kinematics_.bodies(), obstacles = loads_.bodies() - bodies;
  obstacle_loads_.step = loads_.step;
  obstacle_loads_.force_N = loads_.force_N.rightCols(obstacles);
  obstacle_loads_.torque_N_m = loads_.torque_N_m.rightCols(obstacles);
  loads_.force_N.conservativeResize(Eigen::NoChange, bodies);
  loads_.torque_N_m.conservativeResize(Eigen::NoChange, bodies);
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
  observer_.observe({step_, kinematics_, loads_, averaged_, drive_, obstacle_loads_});
}

}  // namespace copepod::coupler
