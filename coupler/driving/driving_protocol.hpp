#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/signal.hpp"
#include "geometry/actuator_loads.hpp"

namespace copepod::coupler {

/// An actuator and how its value varies.
struct DrivenActuator {
  ActuatorSpecification actuator;
  Signal signal;
};

/// The drive of a case: all actuators, sampled at any place inside a step.
class DrivingProtocol {
 public:
  explicit DrivingProtocol(const std::vector<DrivenActuator>& drive) {
    for (const auto& [actuator, signal] : drive) {
      actuators_.push_back(actuator);
      signals_.push_back(signal);
      starts_.push_back(actuator.kind == ActuatorKind::joint_motion ? value_of(signal, 0, 0.0) : 0.0);
      steered_.emplace_back();
    }
  }

  /// Values at times (step + node) of one step; of joints what they have moved since step 0.
  /// @param nodes      fractions of the step
  /// @param actuation  resized to (actuators, nodes) and overwritten
  void sample(std::int64_t step, std::span<const double> nodes, Eigen::MatrixXd& actuation) const {
    actuation.resize(static_cast<Eigen::Index>(signals_.size()), static_cast<Eigen::Index>(nodes.size()));
    for (Eigen::Index i = 0; i < actuation.rows(); ++i) {
      for (Eigen::Index node = 0; node < actuation.cols(); ++node)
        actuation(i, node) = value_of(signals_[i], step, nodes[node]);
      if (starts_[i] != 0.0) actuation.row(i).array() -= starts_[i];
    }
  }

  /// From the start of `step` on, in place of the signal of the case: a value that changes linearly within so many
  /// steps from what it is then, at once if none, and stays.
  void steer(std::size_t actuator, std::int64_t step, double value, std::int64_t steps) {
    const auto start_steps = static_cast<double>(step);
    const double from = value_of(signals_[actuator], step, 0.0) - starts_[actuator];
    const double end_steps = start_steps + static_cast<double>(steps);
    follow(actuator, steps > 0 ? Course{start_steps, from, end_steps, value} : Course{start_steps, value});
  }

  /// Time [steps] and value of one or two points that an actuator moves between since it was steered; empty: never.
  using Course = std::vector<double>;
  [[nodiscard]] const std::vector<Course>& steered() const { return steered_; }

  /// Continues a course.
  void follow(std::size_t actuator, const Course& course) {
    starts_[actuator] = 0.0;
    signals_[actuator] = {.kind = SignalKind::table, .amplitude = 1.0, .table = {}};
    for (std::size_t i = 0; i + 1 < course.size(); i += 2)
      signals_[actuator].table.push_back({course[i], course[i + 1]});
    steered_[actuator] = course;
  }

  /// What the values at the start of a step exert on the bodies.
  /// @param kinematics  at the start of the step
  /// @param loads       resized and overwritten
  void loads(const Kinematics& kinematics, const Eigen::MatrixXd& actuation, Loads& loads) const {
    drive_loads(actuators_, actuation.col(0), kinematics, loads);
  }

 private:
  std::vector<ActuatorSpecification> actuators_;
  std::vector<Signal> signals_;
  std::vector<double> starts_;  ///< of joints, at step 0
  std::vector<Course> steered_;
};

}  // namespace copepod::coupler
