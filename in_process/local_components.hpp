#pragma once

#include "contract/solver_context.hpp"
#include "run/components.hpp"

namespace copepod {

/// Our own fluid and body solvers in the process of the coupler: no messages, the same bits. Ranks of the fluid are
/// threads; rank 0 is the coupler's. A failure of the fluid is thrown as PeerFailed, like that of a service.
class LocalComponents final : public coupler::Components {
 public:
  explicit LocalComponents(int fluid_ranks);

  void connect() override {}
  [[nodiscard]] const Capabilities& fluid_capabilities() const override { return fluid_; }
  [[nodiscard]] const Capabilities& body_capabilities() const override { return body_; }
  std::unique_ptr<FluidSolver> make_fluid(const FluidSetup& setup, std::int64_t first_step) override;
  std::unique_ptr<BodySolver> make_body(const BodySetup& setup, std::int64_t first_step) override;
  void finish() override {}
  void abort(const FailureReport&) noexcept override {}

 private:
  int fluid_ranks_;
  Capabilities fluid_;
  Capabilities body_;
  SolverContext fluid_context_;
  SolverContext body_context_;
};

}  // namespace copepod
