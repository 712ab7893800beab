#pragma once

#include <optional>
#include <string>

#include "session/messages.hpp"

namespace copepod::session {

/// What a Hello is judged against.
struct HelloExpectation {
  VersionRange versions;
  std::string session_token;
  bool role_taken = false;    ///< another component already plays this role on this lane
  std::string identity = {};  ///< with keys: name of the role whose key the component holds
};

/// Accepted with a minor version, or refused for a reason.
struct HelloVerdict {
  std::optional<std::uint32_t> minor;
  std::string reason;        ///< for the component that is refused
  bool is_stranger = false;  ///< wrong token: not a component of this run, so its refusal does not end the run

  [[nodiscard]] bool accepted() const { return minor.has_value(); }
};

/// Decides whether a component may take part. The token comes first: a stranger learns nothing else.
HelloVerdict judge_hello(const Hello& hello, const HelloExpectation& expectation);

/// Whether the holder of the key of `identity` may act as `role`; without keys (empty) the token
/// decides alone.
bool is_entitled(const std::string& identity, Role role);

/// Equality of secrets in a time that does not depend on where they differ.
bool same_token(const std::string& a, const std::string& b);

}  // namespace copepod::session
