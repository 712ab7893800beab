#pragma once

#include <array>
#include <limits>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod::coupler {

/// Judges the motion that a body component reports, whatever fluid it is coupled to: a run whose bodies have
/// left the domain must not finish as if nothing had happened.
class Plausibility {
 public:
  /// @param bodies         names, shapes, initial positions, in the order of Kinematics; must outlive this object
  /// @param largest_speed_m_per_s  of a body's surface [m/s]: what the fluid can follow
  Plausibility(const FluidSetup& fluid, const std::vector<BodySpecification>& bodies,
               double largest_speed_m_per_s = std::numeric_limits<double>::infinity());

  /// A body must be inside the domain (its centre, and only if it began there), must neither move by more than its
  /// radius nor turn by more than one radian in a step, and its orientation must be a unit quaternion. Its surface
  /// must not be faster than the fluid can follow.
  /// @param after  state that follows `before` by one step
  /// @throws PeerFailed in the name of the body component, with body, step and value; numbers that are not
  /// finite fail
  void judge(const Kinematics& before, const Kinematics& after) const;

 private:
  const std::vector<BodySpecification>& bodies_;
  double largest_speed_m_per_s_;
  Eigen::Vector3d length_m_ = Eigen::Vector3d::Zero();  ///< of the domain; 0: unknown
  std::array<bool, 3> periodic_{};
  std::vector<std::array<bool, 3>> confined_;  ///< by body and axis
};

}  // namespace copepod::coupler
