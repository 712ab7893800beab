#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "lattice_boltzmann/boundary/copy_runs.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Fills, before each step, the populations that enter a block from other ranks, and adds what moving walls
/// and pressure faces change; every other face costs nothing (PopulationLayout). All index arithmetic is done
/// once, at construction; per step only runs are copied.
///
/// Five populations cross a face; edges carry one more each. Both sides of a message enumerate its values in
/// the same order by the same arithmetic, so no index ever travels.
template <class T>
class GhostExchange {
 public:
  /// @param body_force_lu  on the fluid, per volume
  GhostExchange(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
                Communicator& communicator, const Eigen::Vector3d& body_force_lu);

  /// Packs and sends what other ranks need; then lets this rank's faces act.
  void start(T* populations, Placement placement);
  /// Waits for the other ranks' populations.
  void wait() { wait_(); }
  /// Puts them in place.
  void finish(T* populations, Placement placement);

  /// Cells from this distance to the block's faces on do not touch another rank's populations:
  /// the block shrunk by one cell where a face has a remote neighbour, relative to the block's low corner.
  [[nodiscard]] const Box& interior() const { return interior_; }
  [[nodiscard]] const std::vector<Box>& border() const { return border_; }  ///< the rest of the block

 private:
  struct Peer {
    int rank = 0;
    std::array<CopyRuns, 2> send;  ///< by placement
    std::array<CopyRuns, 2> receive;
    std::vector<T> send_buffer;
    std::vector<T> receive_buffer;
  };
  struct PressureLink {
    Site cell;          ///< x_f
    int direction = 0;  ///< entering
    double excess_density = 0.0;
  };

  void collect(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
               int rank);
  void split_block(const PopulationLayout& layout, const std::array<bool, 6>& remote);
  void apply_pressure(T* populations, Placement placement);
  Peer& peer(int rank);

  const PopulationLayout& layout_;
  Communicator& communicator_;
  Eigen::Vector3d half_force_;
  std::array<CopyRuns, 2> moving_walls_;  ///< in place; by placement
  std::vector<PressureLink> pressure_;
  std::vector<T> entering_;  ///< through pressure faces
  std::vector<Peer> peers_;
  std::vector<Communicator::Message> messages_;
  std::function<void()> wait_;
  Box interior_;
  std::vector<Box> border_;
};

}  // namespace copepod::fluid
