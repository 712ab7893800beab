#pragma once

#include <optional>
#include <vector>

#include "files/stateless_fluid.hpp"
#include "stokes/plane_images.hpp"

namespace copepod::fluid {

/// Quasi-steady Stokes flow around spheres, in unbounded fluid or beside one no-slip plane: the loads are
/// those that make the spheres move as given,
///   M (F, T) = −(U, Ω)                                     M: stokes/grand_mobility.hpp
/// Neglected: inertia of the fluid, lubrication, other walls.
class StokesFlow final : public StatelessFluid {
 public:
  /// @throws CaseError for bodies that are not spheres
  StokesFlow(const FluidSetup& setup, const Communicator& communicator);

  SolverSummary summarise() override;

 private:
  void add_loads(const Kinematics& kinematics, Loads& loads) override;

  double viscosity_Pa_s_;
  std::vector<double> radius_m_;
  std::optional<NoSlipPlane> plane_;
  double exchange_s_ = 0.0;
};

}  // namespace copepod::fluid
