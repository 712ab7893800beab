#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"
#include "remote/link.hpp"

namespace copepod::coupler {

/// A fluid solver in another process. Legal calls are those of FluidSolver, errors those of Link.
///
/// `exchange` returns when the loads have arrived; the service then does its bulk update by itself, so
/// `advance` sends nothing. A bulk update that fails is thrown by the next call that waits.
class RemoteFluid final : public FluidSolver {
 public:
  /// Sends the setup and waits until the service has built its solver.
  /// @param first_step  step of the first exchange, 0 unless a checkpoint is restored
  RemoteFluid(Link& link, const FluidSetup& setup, std::int64_t first_step);

  void exchange(const Kinematics& kinematics, Loads& loads) override;
  void advance() override {}
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  Link& link_;
  Eigen::Index bodies_;
  std::int64_t next_step_;
};

/// A body solver in another process. Legal calls are those of BodySolver, errors those of Link.
class RemoteBody final : public BodySolver {
 public:
  /// Sends the setup and waits until the service has built its solver.
  /// @param first_step  step of the first call of `step`, 0 unless a checkpoint is restored
  RemoteBody(Link& link, const BodySetup& setup, std::int64_t first_step);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return driving_nodes_; }
  void kinematics(Kinematics& kinematics) override;
  void step(const AppliedLoads& applied, Kinematics& next) override;
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  Link& link_;
  Eigen::Index bodies_;
  std::int64_t next_step_;
  std::vector<double> driving_nodes_;
};

}  // namespace copepod::coupler
