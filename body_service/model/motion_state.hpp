#pragma once

#include <array>

#include <Eigen/Core>

namespace copepod::body {

/// State of motion of a row of bodies, or its rate of change; SI units, world frame, one column per body.
///
/// The rotation is carried as angular momentum: it changes by torques only (B9), so that torque-free motion
/// keeps it to the last bit and the gyroscopic term ω × Iω needs no code of its own. A body that torques do
/// not turn (fixed, prescribed) has unit inertia here, so that its column holds the angular velocity.
template <int Order>
struct MotionArrays {
  Eigen::Matrix<double, 3, Eigen::Dynamic, Order> position_m;
  Eigen::Matrix<double, 4, Eigen::Dynamic, Order> orientation_wxyz;
  Eigen::Matrix<double, 3, Eigen::Dynamic, Order> velocity_m_per_s;
  Eigen::Matrix<double, 3, Eigen::Dynamic, Order> angular_momentum_N_m_s;

  [[nodiscard]] Eigen::Index bodies() const { return position_m.cols(); }
  void resize(Eigen::Index bodies) {
    position_m.resize(3, bodies);
    orientation_wxyz.resize(4, bodies);
    velocity_m_per_s.resize(3, bodies);
    angular_momentum_N_m_s.resize(3, bodies);
  }
};

/// Of all bodies: body by body, as messages have them.
using MotionState = MotionArrays<Eigen::ColMajor>;

/// Vectors of the bodies of a block: component by component, so that loops over bodies use vectors of the processor.
using BlockVectors = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
using BlockState = MotionArrays<Eigen::RowMajor>;

/// Calls act(part of each state) for positions, orientations, velocities and angular momenta, in this order.
template <class... States>
void for_each_part(const auto& act, States&... states) {
  act(states.position_m...);
  act(states.orientation_wxyz...);
  act(states.velocity_m_per_s...);
  act(states.angular_momentum_N_m_s...);
}

/// Where each component of a block's vectors or quaternions begins. Loops take it beforehand: the compiler cannot see
/// that it stays there.
template <class Columns>
auto components(Columns& columns) {
  std::array<decltype(columns.data()), Columns::RowsAtCompileTime> begins{};
  for (std::size_t i = 0; i < begins.size(); ++i)
    begins[i] = columns.data() + static_cast<Eigen::Index>(i) * columns.outerStride();
  return begins;
}

}  // namespace copepod::body
