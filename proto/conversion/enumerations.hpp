#pragma once

#include <string>

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"
#include "conversion/malformed_message.hpp"
#include "copepod/v1/envelope.pb.h"
#include "session/messages.hpp"

namespace copepod::conversion {

// Enumerations on the wire start at 1, ours at 0, in the same order: one shift converts all of them.

template <class Wire, class Ours>
Wire to_wire(Ours value) {
  return static_cast<Wire>(static_cast<int>(value) + 1);
}

/// @param last  newest value of this build
template <class Ours, class Wire>
Ours from_wire(Wire value, Ours last, const char* what) {
  const int number = static_cast<int>(value) - 1;
  if (number < 0 || number > static_cast<int>(last)) {
    throw MalformedMessage(std::string(what) + " has the unknown value " + std::to_string(static_cast<int>(value)));
  }
  return static_cast<Ours>(number);
}

static_assert(v1::SHAPE_KIND_CAPSULE == static_cast<int>(ShapeKind::capsule) + 1);
static_assert(v1::FLUID_KIND_VACUUM == static_cast<int>(FluidKind::vacuum) + 1);
static_assert(v1::BOUNDARY_KIND_PRESSURE == static_cast<int>(BoundaryKind::pressure) + 1);
static_assert(v1::COLLISION_KIND_TRT == static_cast<int>(CollisionKind::trt) + 1);
static_assert(v1::PRECISION_SINGLE == static_cast<int>(Precision::single_precision) + 1);
static_assert(v1::MOTION_KIND_AXIS == static_cast<int>(MotionKind::axis) + 1);
static_assert(v1::INTEGRATOR_RUNGE_KUTTA_4 == static_cast<int>(Integrator::runge_kutta_4) + 1);
static_assert(v1::ROLE_BODY == static_cast<int>(session::Role::body) + 1);
static_assert(v1::LANE_CONTROL == static_cast<int>(session::Lane::control) + 1);
static_assert(v1::PHASE_FINISHING == static_cast<int>(session::Phase::finishing) + 1);

}  // namespace copepod::conversion
