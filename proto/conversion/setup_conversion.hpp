#pragma once

#include <string>
#include <string_view>

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod::v1 {
class BodySetup;
class FluidSetup;
}  // namespace copepod::v1

namespace copepod::conversion {

void write(const FluidSetup& setup, v1::FluidSetup& wire);
void write(const BodySetup& setup, v1::BodySetup& wire);

/// @throws MalformedMessage for wrong lengths, unknown kinds, numbers that are not finite, or indices
/// that do not exist
void read(const v1::FluidSetup& wire, FluidSetup& setup);
void read(const v1::BodySetup& wire, BodySetup& setup);

/// The message alone, as bytes: for the ranks of a component, and for `--estimate`.
std::string to_bytes(const FluidSetup& setup);
std::string to_bytes(const BodySetup& setup);

/// @throws MalformedMessage as `read`, and for bytes that are not such a message
FluidSetup fluid_setup_from_bytes(std::string_view bytes);
BodySetup body_setup_from_bytes(std::string_view bytes);

}  // namespace copepod::conversion
