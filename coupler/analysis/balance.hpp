#pragma once

#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "contract/body_setup.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

/// Momentum and energy of the bodies that loads move, and what they received since the run started; everything needed
/// to continue bit for bit.
struct BalanceSums {
  Eigen::Vector3d start_kg_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d from_fluid_N_s = Eigen::Vector3d::Zero();  ///< Σ F Δt, as the fluid returned the loads
  Eigen::Vector3d from_drive_N_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d withheld_N_s = Eigen::Vector3d::Zero();  ///< Σ (F − F̄) Δt, F̄ what acted on the bodies
  double exchanged_N_s = 0.0;                              ///< Σ |F| Δt, body by body
  double start_J = 0.0;
  double from_fluid_J = 0.0;  ///< Σ (F · v + T · ω) Δt: the opposite is what their surfaces gave to the fluid
  double from_drive_J = 0.0;
};

/// Adds them up [docs/conventions.md].
class Balance final : public Observer {
 public:
  /// @param bodies  those of the run, with their true masses
  Balance(std::vector<BodySpecification> bodies, double step_s) : bodies_(std::move(bodies)), step_s_(step_s) {}

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override { add_motion(last.kinematics, end_kg_m_per_s_, end_J_); }

  [[nodiscard]] const BalanceSums& sums() const { return sums_; }
  void restore(const BalanceSums& sums) { sums_ = sums, started_ = true; }

  /// The part of all impulses that the fluid gave and the bodies have not received.
  [[nodiscard]] double withheld() const {
    return sums_.exchanged_N_s > 0.0 ? sums_.withheld_N_s.norm() / sums_.exchanged_N_s : 0.0;
  }
  /// For summary.json.
  [[nodiscard]] nlohmann::ordered_json report() const;

 private:
  void add_motion(const Kinematics& kinematics, Eigen::Vector3d& momentum_kg_m_per_s, double& energy_J) const;

  std::vector<BodySpecification> bodies_;
  double step_s_;
  BalanceSums sums_;
  bool started_ = false;
  Eigen::Vector3d end_kg_m_per_s_ = Eigen::Vector3d::Zero();
  double end_J_ = 0.0;
};

}  // namespace copepod::coupler
