#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "contract/digest.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/output/fields.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Which state of which lattice a checkpoint holds.
struct PopulationHeader {
  std::uint64_t layout_digest = 0;  ///< layout_digest(setup)
  Cell cells{};                     ///< computed domain
  std::int64_t step = 0;            ///< steps completed
};

/// Digest of what populations belong to: cells, symmetry planes, step, precision, shapes of the bodies.
std::uint64_t layout_digest(const FluidSetup& setup);

/// Momentum of the fluid that changed for numerical reasons, and what to compare it with, in lattice units.
struct MomentumBalance {
  Eigen::Vector3d gained = Eigen::Vector3d::Zero();  ///< what neither a body, a wall nor a force gave
  double exchanged = 0.0;                            ///< sum of |force| over the bodies and all steps

  bool operator==(const MomentumBalance&) const = default;
};

/// State of the fluid beside its populations.
struct FluidState {
  Kinematics kinematics;           ///< of the last exchange, the same on all ranks
  Eigen::Matrix2Xd absorbed_mass;  ///< mass that each body's surface holds, weight of its links; likewise
  MeanField mean;                  ///< this rank's share; may have no samples
  Sampling sampling;               ///< of the mean
  MomentumBalance momentum;        ///< since step 0; the leader's is saved, all ranks receive it
};

/// Digest of a cell's populations, seeded with the cell's index in the domain: sums of it modulo 2^64 are the
/// same for every decomposition.
/// @param populations  called with α = 0 … 18
template <class Populations>
std::uint64_t digest_of_cell(const Cell& domain_cells, const Cell& cell, const Populations& populations) {
  Digest digest(static_cast<std::uint64_t>((cell[0] * domain_cells[1] + cell[1]) * domain_cells[2] + cell[2]));
  for (int alpha = 0; alpha < 19; ++alpha) digest.add(populations(alpha));
  return digest.value();
}

/// Populations travel in pieces of the rank's block, so that no second copy of all of them is ever needed.
/// Arrays are post-collision f_α − w_α, shape (x, y, z, 19) of the piece, 19 fastest.
template <class T>
using GetPopulations = std::function<void(const Box& piece, std::span<T> populations)>;
template <class T>
using TakePopulations =
    std::function<void(const PopulationHeader& header, const Box& piece, std::span<const T> populations)>;

/// Writes a checkpoint: /populations (nx, ny, nz, 19) of the computed domain, /bodies (bodies, 15), the
/// sums of the mean field and the steps that they are of, and a checksum that depends on no decomposition.
/// Collective; complete and synced to disk on return: the file is written under another name and renamed.
///
/// @param T    float or double, as the solver stores its populations
/// @param box  the cells of this rank; all ranks together cover the domain once
/// @param get  called twice for every piece: for the checksum, which comes first, and to write it
/// @throws StorageError on all ranks if one of them cannot write
template <class T>
void save_populations(const std::string& path, Communicator& communicator, const PopulationHeader& header,
                      const Box& box, const GetPopulations<T>& get, const FluidState& state);

/// Reads what save_populations wrote, on any decomposition. Collective.
///
/// @param expected  of the running case; its `step` is ignored
/// @param take      called once for every piece; the values are valid only if nothing is thrown
/// @return header with the step to continue from
/// @throws StorageError on all ranks if the file is missing, damaged (checksum) or of another case
template <class T>
PopulationHeader restore_populations(const std::string& path, Communicator& communicator,
                                     const PopulationHeader& expected, const Box& box, const TakePopulations<T>& take,
                                     FluidState& state);

}  // namespace copepod::fluid
