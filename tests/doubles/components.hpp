#pragma once

#include "contract/component.hpp"

namespace copepod::doubles {

/// The doubles as components.
FluidComponent constant_drag_component();
BodyComponent prescribed_motion_component();
BodyComponent free_point_component();

}  // namespace copepod::doubles
