#include "session/handshake.hpp"

namespace copepod::session {

bool same_token(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return difference == 0;
}

bool is_entitled(const std::string& identity, Role role) { return identity.empty() || identity == name_of(role); }

HelloVerdict judge_hello(const Hello& hello, const HelloExpectation& expectation) {
  const std::string who = "The " + std::string(name_of(hello.role)) + " component on " + hello.host;
  if (!same_token(hello.session_token, expectation.session_token)) {
    return {std::nullopt,
            who +
                " was refused (its session token is not that of this run). Start it with the --session of "
                "this run.",
            true};
  }
  if (!is_entitled(expectation.identity, hello.role)) {
    return {std::nullopt,
            who + " was refused (it holds the key of the " + expectation.identity +
                " component). Give it the key file of its own role.",
            false};
  }
  const auto minor = negotiate(expectation.versions, hello.versions);
  if (!minor) {
    return {std::nullopt,
            who + " was refused (it supports protocol " + to_text(hello.versions) + ", the coupler " +
                to_text(expectation.versions) + "). Build both from the same release.",
            false};
  }
  if (expectation.role_taken) {
    return {std::nullopt,
            who + " was refused (a " + std::string(name_of(hello.role)) +
                " component already takes part). Start one component per role.",
            true};
  }
  return {minor, {}, false};
}

}  // namespace copepod::session
