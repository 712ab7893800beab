#pragma once

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"
#include "copepod/v1/setup.pb.h"

namespace copepod::conversion {

void write(const FluidSetup& setup, v1::FluidSetup& wire);
void write(const BodySetup& setup, v1::BodySetup& wire);

/// @throws MalformedMessage for wrong lengths, unknown kinds, numbers that are not finite, indices out of
/// range
void read(const v1::FluidSetup& wire, FluidSetup& setup);
void read(const v1::BodySetup& wire, BodySetup& setup);

}  // namespace copepod::conversion
