#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "boundary/copy_runs.hpp"
#include "boundary/domain.hpp"
#include "communication/communicator.hpp"
#include "lattice/population_layout.hpp"
#include "partition/block_partition.hpp"

namespace copepod::fluid {

/// Fills, before each step, the populations that enter a block from its ghost cells: from other ranks,
/// periodic images, mirror images and walls. All index arithmetic is done once, at construction; per step
/// only runs are copied.
///
/// Five populations cross a face; edges carry one more each. Both sides of a message enumerate its values in
/// the same order by the same arithmetic, so no index ever travels.
template <class T>
class GhostExchange {
 public:
  GhostExchange(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
                Communicator& communicator);

  /// Packs and sends what other ranks need.
  void start(T* populations, Placement placement);
  /// Fills, from this rank's own populations, what enters the cells of plane x (from the block's low corner).
  /// Right before the plane's update these values are about to be read anyway. Sources and targets are
  /// touched by no update of another cell, since a population that leaves the block belongs to the slots of a
  /// ghost.
  void fill_plane(T* populations, Placement placement, std::int64_t x) const {
    local_[static_cast<std::size_t>(placement)][static_cast<std::size_t>(x)].copy(populations);
  }
  /// Waits for the other ranks' populations and puts them in place.
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
    std::int64_t cell = 0;  ///< x_f
    std::int64_t ghost = 0;
    int direction = 0;  ///< entering: from ghost to x_f
    double excess_density = 0.0;
  };

  void collect(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
               int rank);
  void split_block(const PopulationLayout& layout, const std::array<bool, 6>& remote);
  void apply_pressure(T* populations, Placement placement) const;
  Peer& peer(int rank);

  const PopulationLayout& layout_;
  Communicator& communicator_;
  std::array<std::vector<CopyRuns>, 2> local_;  ///< by placement, by plane of the cell that is entered
  std::vector<PressureLink> pressure_;
  std::vector<Peer> peers_;
  std::vector<Communicator::Message> messages_;
  std::function<void()> wait_;
  Box interior_;
  std::vector<Box> border_;
};

}  // namespace copepod::fluid
