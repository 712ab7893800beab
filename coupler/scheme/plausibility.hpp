#pragma once

#include <array>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod::coupler {

/// Judges the motion that a body component reports, whatever fluid it is coupled to: a run whose bodies have
/// left the domain must not finish as if nothing had happened.
class Plausibility {
 public:
  /// @param bodies  names, radii, initial positions, in the order of Kinematics; must outlive this object
  Plausibility(const FluidSetup& fluid, const std::vector<BodySpecification>& bodies);

  /// A body must be inside the domain (its centre, and only if it began there), must not move by more than
  /// its radius in one step, and its orientation must be a unit quaternion.
  /// @param after  state that follows `before` by one step
  /// @throws PeerFailed in the name of the body component, with body, step and value; numbers that are not
  /// finite fail
  void judge(const Kinematics& before, const Kinematics& after) const;

 private:
  const std::vector<BodySpecification>& bodies_;
  Eigen::Vector3d length_m_ = Eigen::Vector3d::Zero();  ///< of the domain; 0: unknown
  std::array<bool, 3> periodic_{};
  std::vector<std::array<bool, 3>> confined_;  ///< by body and axis
};

}  // namespace copepod::coupler
