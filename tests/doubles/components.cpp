#include "components.hpp"

#include "constant_drag_fluid.hpp"
#include "free_point_body.hpp"
#include "prescribed_motion_body.hpp"

namespace copepod::doubles {

FluidComponent constant_drag_component() {
  return {{"constant drag",
           "1.0",
           {"solver:external", "shape:sphere", "checkpoint", "snapshots", "neglects:boundary",
            "neglects:symmetry_planes", "neglects:fields"}},
          [](const FluidSetup& setup, SolverContext&) { return std::make_unique<ConstantDragFluid>(setup); }};
}

BodyComponent prescribed_motion_component() {
  return {{"prescribed motion", "1.0", {"motion:prescribed", "shape:sphere", "checkpoint", "neglects:loads"}},
          [](const BodySetup& setup, SolverContext&) { return std::make_unique<PrescribedMotionBody>(setup); }};
}

BodyComponent free_point_component() {
  return {{"free point masses", "1.0", {"motion:free", "shape:sphere", "checkpoint", "neglects:torques"}},
          [](const BodySetup& setup, SolverContext&) { return std::make_unique<FreePointBody>(setup); }};
}

}  // namespace copepod::doubles
