#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/boundary/wall.hpp"
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
               Communicator& communicator)
      : communicator_(communicator) {
    for (int rank = 0; rank < partition.ranks(); ++rank)
      if (touches(domain, partition.block(rank), layout.block())) collect(domain, partition, layout, rank);
    for (Peer& peer : peers_) {
      peer.send_buffer.resize(peer.send[0].values());
      peer.receive_buffer.resize(peer.receive[0].values());
    }
    for (Peer& peer : peers_)
      messages_.push_back({peer.rank, std::as_bytes(std::span(peer.send_buffer)),
                           std::as_writable_bytes(std::span(peer.receive_buffer))});
  }

  /// Packs and sends what other ranks need.
  void start(const T* populations, Placement placement) {
    const auto p = static_cast<std::size_t>(placement);
    for (Peer& peer : peers_)
      peer.send[p].for_each(populations, [next = peer.send_buffer.data()](const T& value) mutable { *next++ = value; });
    wait_ = communicator_.start_exchange(messages_);
  }

  /// Waits for the other ranks' populations.
  void wait() { wait_(); }

  /// Puts them in place.
  void finish(T* populations, Placement placement) {
    const auto p = static_cast<std::size_t>(placement);
    for (Peer& peer : peers_)
      peer.receive[p].for_each(populations, [next = peer.receive_buffer.data()](T& value) mutable { value = *next++; });
  }

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

  /// Whether a ghost cell of `a` can stand for a cell of `b`: the boxes touch, perhaps through a periodic face.
  static bool touches(const Domain& domain, const Box& a, const Box& b) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto near = [&](std::int64_t shift) {
        return a.low[axis] - 1 < b.high[axis] + shift && b.low[axis] + shift < a.high[axis] + 1;
      };
      const std::int64_t cells = domain.cells()[axis];
      if (!near(0) && !(domain.periodic(axis) && (near(cells) || near(-cells)))) return false;
    }
    return true;
  }

  /// What `rank` receives from this rank, or, for this rank itself, what it receives from others.
  void collect(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout, int rank) {
    constexpr std::array placements = {Placement::home, Placement::streamed};
    const int self = communicator_.rank();
    const Box block = partition.block(rank);
    std::array<bool, 6> remote{};
    for_each_entering(block, [&](const Cell& ghost, int direction) {
      const GhostSource source = ghost_source(domain, ghost, direction);
      const int owner = partition.owner(source.cell);
      if (rank != self) {
        if (owner != self) return;
        for (std::size_t p = 0; p < 2; ++p)
          peer(rank).send[p].add(layout.location(layout.site(source.cell), source.direction, placements[p]));
      } else if (owner != self) {
        const auto& e = d3q19::e[direction];
        const Site entered = layout.site(Cell{ghost[0] + e[0], ghost[1] + e[1], ghost[2] + e[2]});
        for (std::size_t p = 0; p < 2; ++p) peer(owner).receive[p].add(layout.entry(entered, direction, placements[p]));
        for (int axis = 0; axis < 3; ++axis)
          if (!block.contains_along(axis, source.cell[axis]))
            remote[face_index(axis, ghost[axis] >= block.high[axis])] = true;
      }
    });
    if (rank == self) split_block(block, remote);
  }

  void split_block(const Box& block, const std::array<bool, 6>& remote) {
    interior_ = {{0, 0, 0}, {block.extent(0), block.extent(1), block.extent(2)}};
    for (int axis = 0; axis < 3; ++axis)
      for (const bool high : {false, true}) {
        if (!remote[face_index(axis, high)] || interior_.extent(axis) == 0) continue;
        Box slab = interior_;
        if (high) {
          slab.low[axis] = --interior_.high[axis];
        } else {
          slab.high[axis] = ++interior_.low[axis];
        }
        border_.push_back(slab);
      }
  }

  Peer& peer(int rank) {
    const auto found = std::ranges::find(peers_, rank, &Peer::rank);
    if (found != peers_.end()) return *found;
    peers_.emplace_back().rank = rank;
    return peers_.back();
  }

  Communicator& communicator_;
  std::vector<Peer> peers_;
  std::vector<Communicator::Message> messages_;
  std::function<void()> wait_;
  Box interior_;
  std::vector<Box> border_;
};

}  // namespace copepod::fluid
