#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "contract/body_setup.hpp"
#include "contract/controller.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "remote/link.hpp"
#include "run/components.hpp"
#include "run/program.hpp"

namespace copepod::coupler {

/// A solver in another process. Legal calls are those of FluidSolver or BodySolver, errors those of Link.
template <class Interface>
class RemoteSolver : public Interface {
 public:
  void save(const std::string& path) final;
  void restore(const std::string& path) final;
  SolverSummary summarise() final;

 protected:
  /// @param columns  of the replies in a step
  RemoteSolver(Link& link, std::size_t number, Eigen::Index columns, std::int64_t first_step)
      : link_(link), number_(number), columns_(columns), next_step_(first_step) {}

  Link& link_;
  std::size_t number_;
  Eigen::Index columns_;
  std::int64_t next_step_;
};

/// `exchange` returns when the loads have arrived; the service then does its bulk update by itself, so
/// `advance` sends nothing. A bulk update that fails is thrown by the next call that waits.
class RemoteFluid final : public RemoteSolver<FluidSolver> {
 public:
  /// Sends the setup and waits until the service has built its solver.
  /// @param first_step  step of the first exchange, 0 unless a checkpoint is restored
  RemoteFluid(Link& link, const FluidSetup& setup, std::int64_t first_step);

  void exchange(const Kinematics& kinematics, Loads& loads) override;
  void advance() override {}

 private:
  FlowSampling flow_;
};

class RemoteBody final : public RemoteSolver<BodySolver> {
 public:
  /// Sends the setup and waits until the service has built its solver.
  /// @param first_step  step of the first call of `step`, 0 unless a checkpoint is restored
  RemoteBody(Link& link, const BodySetup& setup, std::int64_t first_step);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return driving_nodes_; }
  void kinematics(Kinematics& kinematics) override;
  void step(const AppliedLoads& applied, Kinematics& next) override;

 private:
  std::vector<double> driving_nodes_;
};

class RemoteController final : public RemoteSolver<Controller> {
 public:
  /// Sends the setup and waits until the component has built its controller.
  /// @param first_step  from which on it may be asked
  RemoteController(Link& link, std::size_t number, const ControllerSetup& setup, std::int64_t first_step);

  [[nodiscard]] std::vector<double> act(const Observation& observation) override;

 private:
  std::vector<double> action_;
};

/// Components in processes of their own, reached over the wire.
class RemoteComponents final : public Components {
 public:
  /// @param options      where they connect, with what token and keys, and where to record messages
  /// @param stop_signal  non-zero ends every wait
  RemoteComponents(const Options& options, const Case& the_case, std::function<int()> stop_signal);

  void connect() override;
  [[nodiscard]] const Capabilities& fluid_capabilities() const override { return link_->capabilities(kFluid); }
  [[nodiscard]] const Capabilities& body_capabilities() const override { return link_->capabilities(kBody); }
  [[nodiscard]] const Capabilities& controller_capabilities(std::size_t number) const override {
    return link_->capabilities(kFirstController + number);
  }
  std::unique_ptr<FluidSolver> make_fluid(const FluidSetup& setup, std::int64_t first_step) override;
  std::unique_ptr<BodySolver> make_body(const BodySetup& setup, std::int64_t first_step) override;
  std::unique_ptr<Controller> make_controller(std::size_t number, const ControllerSetup& setup,
                                              std::int64_t first_step) override;
  void finish() override { link_->finish(); }
  void stay_in_touch_during(const std::function<void()>& work) override { link_->stay_in_touch_during(work); }
  void abort(const FailureReport& report) noexcept override {
    if (link_) link_->abort(report);
  }

 private:
  LinkSettings settings_;
  std::optional<Link> link_;  ///< after connect: binding may fail, and that is a failure of the run
};

}  // namespace copepod::coupler
