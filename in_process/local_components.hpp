#pragma once

#include "ranks/communicator.hpp"
#include "run/components.hpp"

namespace copepod {

/// Our own fluid and body solvers in the process of the coupler: no messages, no waiting, the same bits.
class LocalComponents final : public coupler::Components {
 public:
  LocalComponents();

  void connect() override {}
  [[nodiscard]] const Capabilities& fluid_capabilities() const override { return fluid_; }
  [[nodiscard]] const Capabilities& body_capabilities() const override { return body_; }
  std::unique_ptr<FluidSolver> make_fluid(const FluidSetup& setup, std::int64_t first_step) override;
  std::unique_ptr<BodySolver> make_body(const BodySetup& setup, std::int64_t first_step) override;
  void finish() override {}
  void abort(const FailureReport&) noexcept override {}

 private:
  Capabilities fluid_;
  Capabilities body_;
  SolverContext fluid_context_;
  SolverContext body_context_;
  fluid::SelfCommunicator alone_{fluid_context_};
};

}  // namespace copepod
