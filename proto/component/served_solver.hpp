#pragma once

#include <cstddef>
#include <span>

#include "conversion/decoder.hpp"
#include "conversion/encoder.hpp"
#include "session/header.hpp"
#include "session/role.hpp"
#include "session/transition_table.hpp"

namespace copepod::component {

/// A solver behind the messages of its role.
class ServedSolver {
 public:
  ServedSolver() = default;
  ServedSolver(const ServedSolver&) = delete;
  ServedSolver& operator=(const ServedSolver&) = delete;
  virtual ~ServedSolver() = default;

  [[nodiscard]] virtual session::Role role() const = 0;

  /// Does what a request asks for, up to the reply.
  /// @param header  of the reply
  /// @return the reply's bytes, owned by `encoder`
  /// @throws whatever the solver throws; MalformedMessage if the request makes no sense
  virtual std::span<const std::byte> perform(session::Work work, const conversion::Decoder& request,
                                             const session::Header& header, conversion::Encoder& encoder) = 0;

  /// The bulk update after the reply to `work`, if there is one.
  virtual void follow_up(session::Work work) = 0;
};

}  // namespace copepod::component
