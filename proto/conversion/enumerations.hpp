#pragma once

#include <string>

#include <google/protobuf/descriptor.h>

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"
#include "conversion/limits.hpp"
#include "copepod/v1/envelope.pb.h"
#include "session/messages.hpp"

namespace copepod::conversion {

// Enumerations on the wire start at 1, ours at 0, in the same order: one shift converts all of them.

template <class Wire, class Ours>
constexpr Wire to_wire(Ours value) {
  return static_cast<Wire>(static_cast<int>(value) + 1);
}

/// @param known  the enumeration on the wire
template <class Ours>
Ours from_wire(int value, const google::protobuf::EnumDescriptor& known, const char* what) {
  if (value == 0 || known.FindValueByNumber(value) == nullptr)
    throw MalformedMessage(std::string(what) + " has the unknown value " + std::to_string(value));
  return static_cast<Ours>(value - 1);
}

// Both end with the same enumerator.
static_assert(v1::ShapeKind_MAX == to_wire<v1::ShapeKind>(ShapeKind::compound));
static_assert(v1::FluidKind_MAX == to_wire<v1::FluidKind>(FluidKind::vacuum));
static_assert(v1::BoundaryKind_MAX == to_wire<v1::BoundaryKind>(BoundaryKind::outflow));
static_assert(v1::SignalKind_MAX == to_wire<v1::SignalKind>(SignalKind::table));
static_assert(v1::InitialFlowKind_MAX == to_wire<v1::InitialFlowKind>(InitialFlowKind::file));
static_assert(v1::CollisionKind_MAX == to_wire<v1::CollisionKind>(CollisionKind::central_moments));
static_assert(v1::MovingBoundary_MAX == to_wire<v1::MovingBoundary>(MovingBoundary::parabolic));
static_assert(v1::Refill_MAX == to_wire<v1::Refill>(Refill::grad));
static_assert(v1::Precision_MAX == to_wire<v1::Precision>(Precision::single_precision));
static_assert(v1::FieldQuantity_MAX == to_wire<v1::FieldQuantity>(FieldQuantity::vorticity));
static_assert(v1::MotionKind_MAX == to_wire<v1::MotionKind>(MotionKind::axis));
static_assert(v1::ActuatorKind_MAX == to_wire<v1::ActuatorKind>(ActuatorKind::control));
static_assert(v1::JointKind_MAX == to_wire<v1::JointKind>(JointKind::model));
static_assert(v1::Integrator_MAX == to_wire<v1::Integrator>(Integrator::runge_kutta_4));
static_assert(v1::Role_MAX == to_wire<v1::Role>(session::Role::controller));
static_assert(v1::Lane_MAX == to_wire<v1::Lane>(session::Lane::control));
static_assert(v1::Phase_MAX == to_wire<v1::Phase>(session::Phase::finishing));

}  // namespace copepod::conversion
