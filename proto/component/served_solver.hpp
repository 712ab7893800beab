#pragma once

#include <memory>

#include "contract/component.hpp"
#include "conversion/codec.hpp"
#include "session/messages.hpp"
#include "session/transition_table.hpp"

namespace copepod::component {

/// What a message asks for, and how to answer it.
struct Request {
  session::Work work;
  const conversion::Decoder& message;
  const session::Header& header;  ///< of the reply
  conversion::Encoder& encoder;   ///< owns the bytes of the reply
};

/// A solver behind the messages of its role.
class ServedSolver {
 public:
  virtual ~ServedSolver() = default;

  [[nodiscard]] virtual session::Role role() const = 0;

  /// Does what a request asks for, up to the reply, and returns that.
  /// @throws whatever the solver throws; MalformedMessage if the request makes no sense
  virtual conversion::Bytes perform(const Request& request) = 0;

  /// The bulk update after the reply to `work`, if there is one.
  virtual void follow_up(session::Work /*work*/) {}
};

/// What both roles do alike.
template <class Setup, class Solver>
class Served : public ServedSolver {
 public:
  /// Both outlive this object.
  Served(const Component<Setup, Solver>& component, SolverContext& context)
      : component_(component), context_(context) {}

  conversion::Bytes perform(const Request& request) final;

 protected:
  /// The answer to the setup, now that the solver is there.
  virtual session::Configured configured(const Setup& setup) = 0;

  /// Does what only this role is asked for.
  virtual conversion::Bytes exchange(const Request& request) = 0;

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
  conversion::Bytes exchange(const Request& request) override;

  Eigen::Index columns_ = 0;  ///< of the loads
  FlowSampling flow_;
  Loads loads_;
};

/// A Controller behind the messages of its role.
class ServedController final : public Served<ControllerSetup, Controller> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::controller; }

 private:
  session::Configured configured(const ControllerSetup& setup) override;
  conversion::Bytes exchange(const Request& request) override;

  std::size_t actuators_ = 0;
  Eigen::Index flow_ = 0;  ///< values of a sample
  Observation observation_;
};

/// A BodySolver behind the messages of the body role.
class ServedBody final : public Served<BodySetup, BodySolver> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::body; }

 private:
  session::Configured configured(const BodySetup& setup) override;
  conversion::Bytes exchange(const Request& request) override;

  Eigen::Index actuators_ = 0;
  Eigen::Index driving_nodes_ = 1;
  AppliedLoads applied_;
};

}  // namespace copepod::component
