#pragma once

#include <vector>

#include "contract/body_setup.hpp"
#include "contract/solver.hpp"

namespace copepod::doubles {

/// What the body doubles share: translating bodies whose state is one Kinematics.
class PointBodies : public BodySolver {
 public:
  explicit PointBodies(const BodySetup& setup);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0}; }
  void kinematics(Kinematics& kinematics) override { kinematics = state_; }
  void step(const AppliedLoads& applied, Kinematics& next) override;

  /// The state is written bit for bit.
  void save(const std::string& path) override;
  void restore(const std::string& path) override;

  SolverSummary summarise() override;

 protected:
  /// Changes the velocities from the start to the end of a step.
  virtual void accelerate(const AppliedLoads& applied, Kinematics& state) = 0;
  [[nodiscard]] double step_s() const { return step_s_; }

 private:
  double step_s_;
  Kinematics state_;
};

}  // namespace copepod::doubles
