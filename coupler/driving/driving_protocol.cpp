#include "driving/driving_protocol.hpp"

#include "geometry/actuator_loads.hpp"

namespace copepod::coupler {

DrivingProtocol::DrivingProtocol(const std::vector<DrivenActuator>& drive) {
  for (const auto& [actuator, signal] : drive) {
    actuators_.push_back(actuator);
    signals_.push_back(signal);
  }
}

void DrivingProtocol::sample(std::int64_t step, std::span<const double> nodes, Eigen::MatrixXd& actuation) const {
  actuation.resize(static_cast<Eigen::Index>(signals_.size()), static_cast<Eigen::Index>(nodes.size()));
  for (Eigen::Index i = 0; i < actuation.rows(); ++i) {
    const Signal& signal = signals_[static_cast<std::size_t>(i)];
    for (Eigen::Index node = 0; node < actuation.cols(); ++node) {
      actuation(i, node) = value_of(signal, step, nodes[static_cast<std::size_t>(node)]);
    }
    if (actuators_[static_cast<std::size_t>(i)].kind == ActuatorKind::joint_motion)
      actuation.row(i).array() -= value_of(signal, 0, 0.0);
  }
}

void DrivingProtocol::loads(const Kinematics& kinematics, const Eigen::MatrixXd& actuation, Loads& loads) const {
  drive_loads(actuators_, actuation.col(0), kinematics, loads);
}

}  // namespace copepod::coupler
