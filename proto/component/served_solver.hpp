#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "contract/component.hpp"
#include "conversion/codec.hpp"
#include "session/messages.hpp"
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

/// What both roles do alike.
template <class Setup, class Solver>
class Served : public ServedSolver {
 public:
  /// Both outlive this object.
  Served(const Component<Setup, Solver>& component, SolverContext& context)
      : component_(component), context_(context) {}

  std::span<const std::byte> perform(session::Work work, const conversion::Decoder& request,
                                     const session::Header& header, conversion::Encoder& encoder) final;

 protected:
  /// The answer to the setup, now that the solver is there.
  virtual session::Configured configured(const Setup&) { return {}; }

  /// Does what only this role is asked for.
  virtual std::span<const std::byte> exchange(session::Work work, const conversion::Decoder& request,
                                              const session::Header& header, conversion::Encoder& encoder) = 0;

  const Component<Setup, Solver>& component_;
  SolverContext& context_;
  std::unique_ptr<Solver> solver_;
  Eigen::Index bodies_ = 0;
  Kinematics kinematics_;
};

/// A FluidSolver behind the messages of the fluid role. Kinematics are answered with loads first; the bulk
/// update comes after the reply, while the others work.
class ServedFluid final : public Served<FluidSetup, FluidSolver> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::fluid; }
  void follow_up(session::Work work) override {
    if (work == session::Work::compute_loads) solver_->advance();
  }

 private:
  session::Configured configured(const FluidSetup& setup) override;
  std::span<const std::byte> exchange(session::Work work, const conversion::Decoder& request,
                                      const session::Header& header, conversion::Encoder& encoder) override;

  Eigen::Index columns_ = 0;  ///< of the loads
  FlowSampling flow_;
  Loads loads_;
};

/// A Controller behind the messages of its role.
class ServedController final : public Served<ControllerSetup, Controller> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::controller; }
  void follow_up(session::Work) override {}

 private:
  session::Configured configured(const ControllerSetup& setup) override;
  std::span<const std::byte> exchange(session::Work work, const conversion::Decoder& request,
                                      const session::Header& header, conversion::Encoder& encoder) override;

  std::size_t actuators_ = 0;
  Eigen::Index flow_ = 0;  ///< values of a sample
  Observation observation_;
};

/// A BodySolver behind the messages of the body role.
class ServedBody final : public Served<BodySetup, BodySolver> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::body; }
  void follow_up(session::Work) override {}

 private:
  session::Configured configured(const BodySetup& setup) override;
  std::span<const std::byte> exchange(session::Work work, const conversion::Decoder& request,
                                      const session::Header& header, conversion::Encoder& encoder) override;

  Eigen::Index actuators_ = 0;
  Eigen::Index driving_nodes_ = 1;
  AppliedLoads applied_;
};

}  // namespace copepod::component
