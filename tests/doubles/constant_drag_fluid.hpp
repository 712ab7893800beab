#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "contract/digest.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"

namespace copepod::doubles {

/// A fluid without memory: Stokes drag on every body, that of an isolated sphere of its radius.
///   F = −6π η r v,   T = −8π η r³ ω                          [Happel & Brenner 1983, eqs. (4-17.19),
///   (5-2.4)]
/// Neglects the other bodies, the walls, the cylinder of capsules and the inertia of the fluid.
class ConstantDragFluid : public FluidSolver {
 public:
  explicit ConstantDragFluid(const FluidSetup& setup);

  void exchange(const Kinematics& kinematics, Loads& loads) override;
  void advance() override;

  /// The state is the number of steps and the digest of all kinematics so far.
  void save(const std::string& path) override;
  void restore(const std::string& path) override;

  SolverSummary summarise() override;

 private:
  double viscosity_Pa_s_;
  std::vector<double> radius_m_;
  std::uint64_t steps_ = 0;
  std::uint64_t digest_ = 0;
};

}  // namespace copepod::doubles
