#pragma once

#include <vector>

#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"

namespace copepod::fluid {

/// Quasi-steady Stokes flow around spheres in unbounded fluid: the loads are those that make the spheres move
/// as given,
///   M (F, T) = −(U, Ω)                                     M: stokes/grand_mobility.hpp
/// Neglected: inertia of the fluid, walls, lubrication. Has no state but the last kinematics.
class StokesFlow final : public FluidSolver {
 public:
  /// @throws CaseError for bodies that are not spheres
  explicit StokesFlow(const FluidSetup& setup);

  void exchange(const Kinematics& kinematics, Loads& loads) override;
  void advance() override;
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  double viscosity_Pa_s_;
  std::vector<double> radius_m_;
  double exchange_s_ = 0.0;
};

}  // namespace copepod::fluid
