#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/controller.hpp"
#include "contract/exchange.hpp"
#include "contract/signal.hpp"
#include "geometry/actuator_loads.hpp"

namespace copepod::coupler {

/// An actuator and how its value varies.
struct DrivenActuator {
  ActuatorSpecification actuator;
  Signal signal;
};

/// A body whose velocities are those of its specification times a signal.
struct PrescribedBody {
  int body = 0;
  Signal signal;
};

/// What drives a case: its actuators, sampled at any place inside a step, and behind them its prescribed bodies.
class DrivingProtocol {
 public:
  explicit DrivingProtocol(const std::vector<DrivenActuator>& drive, const std::vector<PrescribedBody>& prescribed = {})
      : ways_(prescribed.size()) {
    for (const auto& [actuator, signal] : drive) {
      actuators_.push_back(actuator);
      signals_.push_back(signal);
      starts_.push_back(actuator.kind == ActuatorKind::joint_motion ? value_of(signal, 0, 0.0) : 0.0);
    }
    for (const PrescribedBody& each : prescribed) signals_.push_back(each.signal);
    starts_.resize(signals_.size());
    steered_.resize(signals_.size());
  }

  /// Values at times (step + node) of one step; of joints what they have moved since step 0.
  /// @param nodes      fractions of the step
  /// @param actuation  resized to (actuators, nodes) and overwritten
  void sample(std::int64_t step, std::span<const double> nodes, Eigen::MatrixXd& actuation) const {
    actuation.resize(actuators_.size(), nodes.size());
    for (Eigen::Index i = 0; i < actuation.rows(); ++i) {
      for (Eigen::Index node = 0; node < actuation.cols(); ++node)
        actuation(i, node) = value_of(signals_[i], step, nodes[node]);
      if (starts_[i] != 0.0) actuation.row(i).array() -= starts_[i];
    }
  }

  /// Signal of a prescribed body at the start of a step, and its integral from step 0 on [steps]. Of later steps only,
  /// one after the other: after a restart all are summed anew, in the same order, and the sum keeps its bits.
  std::pair<double, double> prescribed(std::size_t number, std::int64_t step) {
    const Signal& signal = signals_[actuators_.size() + number];
    Way& way = ways_[number];
    for (; way.summed_steps < step; ++way.summed_steps) {
      const double part = integral_over_step(signal, way.summed_steps) - way.excess;
      const double before = std::exchange(way.steps, way.steps + part);
      way.excess = (way.steps - before) - part;
    }
    return {value_of(signal, step, 0.0), way.steps};
  }

  /// From the start of `step` on, in place of the signal of the case: a value that changes linearly within so many
  /// steps from what it is then, at once if none, and stays.
  /// @param number  of the actuator, or of the prescribed body behind them
  void steer(std::size_t number, std::int64_t step, double value, std::int64_t steps) {
    const auto start_steps = static_cast<double>(step);
    const double from = value_of(signals_[number], step, 0.0) - starts_[number];
    const double end_steps = start_steps + static_cast<double>(steps);
    follow(number, steps > 0 ? Course{start_steps, from, end_steps, value} : Course{start_steps, value});
  }

  /// Time [steps] and value of one or two points that something moves between since it was steered; empty: never.
  using Course = std::vector<double>;
  [[nodiscard]] const std::vector<Course>& steered() const { return steered_; }

  /// Continues a course.
  void follow(std::size_t number, const Course& course) {
    starts_[number] = 0.0;
    signals_[number] = {.kind = SignalKind::table, .amplitude = 1.0, .table = {}};
    for (std::size_t i = 0; i + 1 < course.size(); i += 2) signals_[number].table.push_back({course[i], course[i + 1]});
    steered_[number] = course;
  }

  /// ∫ w dt over so many steps of a signal w, and what rounding added to it, which the next part lacks [Kahan, CACM 8,
  /// 40, 1965].
  struct Way {
    std::int64_t summed_steps = 0;
    double steps = 0.0;
    double excess = 0.0;

    bool operator==(const Way&) const = default;
  };
  /// Of the prescribed bodies.
  [[nodiscard]] const std::vector<Way>& ways() const { return ways_; }
  /// Continues the way of one that was steered.
  void resume_way(std::size_t number, const Way& way) { ways_[number] = way; }

  /// What the values at the start of a step exert on the bodies.
  /// @param kinematics  at the start of the step
  /// @param loads       resized and overwritten
  void loads(const Kinematics& kinematics, const Eigen::MatrixXd& actuation, Loads& loads) const {
    drive_loads(actuators_, actuation.col(0), kinematics, loads);
  }

 private:
  std::vector<ActuatorSpecification> actuators_;
  std::vector<Signal> signals_;  ///< of the prescribed bodies, too
  std::vector<double> starts_;   ///< of joints, at step 0
  std::vector<Course> steered_;
  std::vector<Way> ways_;
};

/// A controller and what it is joined to.
struct AttachedController {
  std::unique_ptr<Controller> controller;
  std::int64_t every_steps = 1;
  std::vector<Eigen::Index> bodies;  ///< that it observes
  struct Actuator {
    std::size_t number = 0;  ///< in the drive
    double factor = 1.0;     ///< stiffness where a rest length acts as a force
    bool moves = false;      ///< until the next action, instead of at once
  };
  std::vector<Actuator> actuators;
  Eigen::Index flow = 0;  ///< values of a sample
};

/// Asks the controllers of a case in the steps of theirs, one after the other, and steers the drive.
class Controllers {
 public:
  /// None.
  Controllers() = default;
  /// @param driving  outlives this object
  Controllers(std::vector<AttachedController> controllers, DrivingProtocol& driving)
      : controllers_(std::move(controllers)), driving_(&driving) {}

  /// @param kinematics  of all bodies at the start of the step
  /// @param loads       hydrodynamic, on all of them during the step before
  void act(const Kinematics& kinematics, const Loads& loads) {
    for (AttachedController& each : controllers_) {
      if (kinematics.step % each.every_steps != 0) continue;
      observe(each.bodies, kinematics, loads);
      observation_.loads.flow = loads.flow;
      if (loads.flow.size() == 0) observation_.loads.flow.setZero(each.flow);
      const std::vector<double> action = each.controller->act(observation_);
      for (std::size_t i = 0; i < action.size(); ++i) {
        const auto& [number, factor, moves] = each.actuators[i];
        driving_->steer(number, kinematics.step, factor * action[i], moves ? each.every_steps : 0);
      }
    }
  }

  [[nodiscard]] const std::vector<AttachedController>& all() const { return controllers_; }

 private:
  void observe(const std::vector<Eigen::Index>& bodies, const Kinematics& kinematics, const Loads& loads) {
    Kinematics& seen = observation_.kinematics;
    seen.step = kinematics.step;
    seen.position_m = kinematics.position_m(Eigen::all, bodies);
    seen.orientation_wxyz = kinematics.orientation_wxyz(Eigen::all, bodies);
    seen.velocity_m_per_s = kinematics.velocity_m_per_s(Eigen::all, bodies);
    seen.angular_velocity_rad_per_s = kinematics.angular_velocity_rad_per_s(Eigen::all, bodies);
    observation_.loads.step = kinematics.step - 1;
    observation_.loads.force_N = loads.force_N(Eigen::all, bodies);
    observation_.loads.torque_N_m = loads.torque_N_m(Eigen::all, bodies);
  }

  std::vector<AttachedController> controllers_;
  DrivingProtocol* driving_ = nullptr;
  Observation observation_;
};

}  // namespace copepod::coupler
