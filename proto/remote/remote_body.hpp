#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"
#include "remote/link.hpp"

namespace copepod {

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
  remote::Exchange& exchange_;
  Eigen::Index bodies_;
  std::int64_t next_step_;
  std::vector<double> driving_nodes_;
};

}  // namespace copepod
