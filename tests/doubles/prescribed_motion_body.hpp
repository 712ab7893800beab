#pragma once

#include "point_bodies.hpp"

namespace copepod::doubles {

/// Bodies that keep their given velocities, whatever acts on them: x(t) = x₀ + v₀ t.
class PrescribedMotionBody final : public PointBodies {
 public:
  using PointBodies::PointBodies;

 private:
  void accelerate(const AppliedLoads&, Kinematics&) override {}
};

}  // namespace copepod::doubles
