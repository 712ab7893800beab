#pragma once

#include <memory>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"
#include "driving/signal.hpp"
#include "geometry/shapes/overlaps.hpp"

namespace copepod::coupler {

/// A body whose velocities are those of its specification times a signal.
struct PrescribedBody {
  int body = 0;
  Signal signal;
};

/// Takes prescribed bodies out of a setup; nothing in it may act on them.
/// @param prescribed  ascending
void take_out(const std::vector<PrescribedBody>& prescribed, BodySetup& setup);

/// All bodies of a case, of which the body component has those that are not prescribed. The position of a prescribed
/// body follows from the number of the step alone, with w the signal:
///   x(n) = x(0) + V Δt ∫₀ⁿ w dt,   q(n) = exp(Ω Δt ∫₀ⁿ w dt / 2) ⊗ q(0)                              (C18)
/// Prescribed bodies do not collide: a run ends where one overlaps with another body.
class PrescribedBodies final : public BodySolver {
 public:
  /// @param others  has the bodies that are left by `take_out`
  /// @param bodies  all of them
  /// @param setup   what `take_out` left; step and periodic lengths count
  PrescribedBodies(std::unique_ptr<BodySolver> others, const std::vector<BodySpecification>& bodies,
                   std::vector<PrescribedBody> prescribed, const BodySetup& setup);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return others_->driving_nodes(); }
  void kinematics(Kinematics& kinematics) override;
  void step(const AppliedLoads& applied, Kinematics& next) override;
  void save(const std::string& path) override { others_->save(path); }
  void restore(const std::string& path) override { others_->restore(path); }
  SolverSummary summarise() override { return others_->summarise(); }

 private:
  /// All bodies from those of the component.
  void complete(Kinematics& kinematics);
  void check_overlaps(const Kinematics& kinematics) const;

  std::unique_ptr<BodySolver> others_;
  std::vector<BodySpecification> bodies_;
  std::vector<PrescribedBody> prescribed_;
  std::vector<Eigen::Index> free_;  ///< numbers of the others' bodies
  double step_s_;
  Overlaps overlaps_;
  std::int64_t summed_steps_ = 0;
  /// ∫ w dt over these steps and what rounding added to it, which the next part lacks [Kahan, CACM 8, 40, 1965].
  struct SignalSum {
    double steps = 0.0;
    double excess = 0.0;
  };
  std::vector<SignalSum> signal_sums_;  ///< by prescribed body
  Kinematics others_kinematics_;
  AppliedLoads others_applied_;
};

}  // namespace copepod::coupler
