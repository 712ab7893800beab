#pragma once

#include <string>

#include "session/messages.hpp"

namespace copepod::session {

/// Plays the first column of a transcript to a component's session and writes the other two.
///
/// A line is `> Message #sequence @step ~foreign | state | what the component does` for a message from the
/// coupler, or
/// `! event | state | …` for something inside the component. `#`, `@` are optional; `~foreign` marks a
/// message that carries another run's ids. Returns the transcript as it really went: equal to `transcript` if
/// all went as written.
std::string replay(Role role, const std::string& transcript);

}  // namespace copepod::session
