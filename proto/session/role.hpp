#pragma once

#include <string_view>

namespace copepod::session {

/// What a component is to the coupler; a run has one of each.
enum class Role { fluid, body };

/// Which of a component's two sockets a message travels on.
enum class Lane { data, control };

constexpr std::string_view name_of(Role role) { return role == Role::fluid ? "fluid" : "body"; }
constexpr std::string_view name_of(Lane lane) { return lane == Lane::data ? "data" : "control"; }

}  // namespace copepod::session
