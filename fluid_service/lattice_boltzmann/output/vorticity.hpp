#pragma once

#include <array>
#include <optional>
#include <vector>

#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/output/fields.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Vorticity of the velocity field of output, by central differences.
///   ω = ∇ × u,   ∂u/∂x ≈ (u(x + Δx) − u(x − Δx)) / (2 Δx)
/// In cells of bodies it is zero; beside them, their surface velocity is that of the cells they cover. Beyond a mirror
/// lies the mirror image, beyond a wall 2 u_wall − u, which is exact for linear flow; beside an open face the
/// difference is one-sided. One layer of velocities travels between ranks, so every decomposition gives the same bits.
class Vorticity {
 public:
  /// @param communicator  of ranks that hold the blocks of BlockPartition; outlives this object
  Vorticity(const FluidSetup& setup, Communicator& communicator);

  /// Collective.
  /// @return [1/s], shape (x, y, z, 3) as the velocity
  [[nodiscard]] std::vector<double> operator()(const FieldBlock& block) const;

 private:
  /// Velocities in the layer of ghost cells beyond a face of the block, in the order of its cells; none: open.
  using Layer = std::optional<std::vector<double>>;

  [[nodiscard]] int rank_beyond(const Box& block, int axis, bool high) const;
  [[nodiscard]] std::array<Layer, 6> layers_around(const FieldBlock& block) const;
  [[nodiscard]] Layer local_layer(const FieldBlock& block, int axis, bool high) const;
  void receive_layers(const FieldBlock& block, std::array<Layer, 6>& layers) const;

  LatticeUnits units_;
  Domain domain_;
  BlockPartition partition_;
  double cell_size_m_;
  Communicator& communicator_;
};

}  // namespace copepod::fluid
