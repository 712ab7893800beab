#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "contract/component.hpp"
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

/// A FluidSolver behind the messages of the fluid role. Kinematics are answered with loads first; the bulk
/// update comes after the reply, while the others work.
class ServedFluid final : public ServedSolver {
 public:
  /// Both outlive this object.
  ServedFluid(const FluidComponent& component, SolverContext& context) : component_(component), context_(context) {}

  [[nodiscard]] session::Role role() const override { return session::Role::fluid; }
  std::span<const std::byte> perform(session::Work work, const conversion::Decoder& request,
                                     const session::Header& header, conversion::Encoder& encoder) override;
  void follow_up(session::Work work) override;

 private:
  void make_solver(const conversion::Decoder& request);
  void compute_loads(const conversion::Decoder& request);

  const FluidComponent& component_;
  SolverContext& context_;
  std::unique_ptr<FluidSolver> solver_;
  Eigen::Index bodies_ = 0;
  Kinematics kinematics_;
  Loads loads_;
};

/// A BodySolver behind the messages of the body role.
class ServedBody final : public ServedSolver {
 public:
  /// Both outlive this object.
  ServedBody(const BodyComponent& component, SolverContext& context) : component_(component), context_(context) {}

  [[nodiscard]] session::Role role() const override { return session::Role::body; }
  std::span<const std::byte> perform(session::Work work, const conversion::Decoder& request,
                                     const session::Header& header, conversion::Encoder& encoder) override;
  void follow_up(session::Work) override {}

 private:
  session::Configured make_solver(const conversion::Decoder& request);
  void advance_bodies(const conversion::Decoder& request);

  const BodyComponent& component_;
  SolverContext& context_;
  std::unique_ptr<BodySolver> solver_;
  Eigen::Index bodies_ = 0;
  Eigen::Index driving_nodes_ = 1;
  AppliedLoads applied_;
  Kinematics kinematics_;
};

}  // namespace copepod::component
