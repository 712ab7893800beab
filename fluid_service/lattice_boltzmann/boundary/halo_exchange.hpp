#pragma once

#include <array>
#include <functional>
#include <vector>

#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/boundary/runs.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Brings in, before each step, the populations that enter a block from other ranks. All index arithmetic is
/// done once, at construction; per step only runs are copied.
///
/// Five populations cross a face; edges carry one more each. Both sides of a message enumerate its values in
/// the same order by the same arithmetic, so no index ever travels.
template <class T>
class HaloExchange {
 public:
  HaloExchange(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
               Communicator& communicator);

  /// Packs and sends what other ranks need.
  void start(const T* populations, Placement placement);
  /// Waits for the other ranks' populations.
  void wait() { wait_(); }
  /// Puts them in place.
  void finish(T* populations, Placement placement);

  /// Cells that do not touch another rank's populations: the block shrunk by one cell where a face has a
  /// remote neighbour, relative to the block's low corner.
  [[nodiscard]] const Box& interior() const { return interior_; }
  [[nodiscard]] const std::vector<Box>& border() const { return border_; }  ///< the rest of the block

 private:
  struct Peer {
    int rank = 0;
    std::array<Runs, 2> send;  ///< by placement
    std::array<Runs, 2> receive;
    std::vector<T> send_buffer;
    std::vector<T> receive_buffer;
  };

  void collect(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
               int rank);
  void split_block(const Box& block, const std::array<bool, 6>& remote);
  Peer& peer(int rank);

  Communicator& communicator_;
  std::vector<Peer> peers_;
  std::vector<Communicator::Message> messages_;
  std::function<void()> wait_;
  Box interior_;
  std::vector<Box> border_;
};

}  // namespace copepod::fluid
