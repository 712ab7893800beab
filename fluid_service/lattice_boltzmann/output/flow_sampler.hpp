#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/bodies/load_sums.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/output/fields.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Samples the flow as FlowSampling asks. All sums are of integers: every decomposition gives the same bits.
///   E = ½ ∫ ρ u² dV,   ε = 2 ρ₀ ν ∫ S:S dV,   ½ ∫ ω² dV,   ∫ ρ u dV        over all cells of fluid
/// with S and ω from central differences. At a probe velocity and pressure are linear between the centres of the eight
/// cells around it: those of bodies have the velocity of the surface and take no part in the pressure, which is 0 where
/// there are only such. Beyond a wall or an open face lies what is in front of it.
///
/// Through a face of the domain the fluid loses, in the step that follows, the momentum of what leaves and gains that
/// of what enters, pressure relative to rest:
///   F = Σ e_ᾱ (f̃_ᾱ + f_α),   Q = Σ (f_α − f̃_ᾱ)/ρ₀        over all links of cells of fluid through it
/// Where a link meets an edge of two faces, each gets the component normal to it. That has half a cell of the shear on
/// a wall beside an open face, which the wall gets: as much as half a cell further on has. So the forces on faces,
/// bodies and obstacles are together what drives the fluid less what its momentum changes by.
class FlowSampler {
 public:
  /// A link through faces of the domain, and the populations that take it in the next step.
  struct Crossing {
    Cell ghost{};
    int direction = 0;      ///< α, into the fluid
    double leaving = 0.0;   ///< f̃_ᾱ, less w_α
    double entering = 0.0;  ///< f_α, less w_α
  };
  using VisitCrossing = std::function<void(const Crossing&)>;

  /// @param domain        outlives this object, like the communicator
  /// @param block         of this rank
  FlowSampler(const FluidSetup& setup, const Domain& domain, const Box& block, Communicator& communicator);

  /// Collective.
  /// @param fields     of cells of this rank
  /// @param crossings  visits all links between fluid of this rank and faces of the computed domain
  /// @return on rank 0 the values [FlowSampling::names]
  [[nodiscard]] Eigen::VectorXd operator()(const std::function<FieldBlock(const Box&)>& fields,
                                           const std::function<void(const VisitCrossing&)>& crossings) const;

 private:
  /// One of the cells around a probe, in the computed domain.
  struct Corner {
    Cell cell{};
    double weight = 1.0;
    Eigen::Vector3d sign{1, 1, 1};  ///< of the velocity: −1 beyond a mirror
  };
  [[nodiscard]] static std::vector<Corner> corners_around(const Eigen::Vector3d& position_lu, const Domain& domain);
  void add_totals(const FieldBlock& block, fixed_point::Sum* sums) const;
  void add_probe(const std::vector<Corner>& corners, const std::function<FieldBlock(const Box&)>& fields,
                 fixed_point::Sum* sums) const;
  /// Adds to the sums of all six faces.
  void add_crossing(const Crossing& crossing, fixed_point::Sum* sums) const;

  FluidSetup setup_;
  const Domain& domain_;
  Box block_;
  Communicator& communicator_;
  std::vector<std::vector<Corner>> probes_;
};

}  // namespace copepod::fluid
