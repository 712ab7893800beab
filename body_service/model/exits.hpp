#pragma once

#include <vector>

#include "contract/body_setup.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// The exits of a setup. Behind one, bodies rest in a row along its normal, so far from each other and from it that
/// nothing meets them. Whether a body was removed follows from its place alone.
class Exits {
 public:
  Exits(const BodySetup& setup, const BodyModel& model);

  [[nodiscard]] bool empty() const { return exits_.empty() || free_to_go_.empty(); }

  /// Removes bodies that have reached an exit in a step, and keeps those at rest that were removed before.
  /// @param before_m  positions at its start
  /// @param state     at its end
  void remove_bodies(const Eigen::Matrix3Xd& before_m, MotionState& state) const;

 private:
  struct FreeToGo {
    Eigen::Index body = 0;
    double radius_m = 0.0;  ///< of its bounding ball
    double depth_m = 0.0;   ///< of its place behind an exit
  };

  std::vector<WallSpecification> exits_;
  std::vector<FreeToGo> free_to_go_;
};

}  // namespace copepod::body
