#include "lattice_boltzmann/boundary/ghost_exchange.hpp"

#include <algorithm>
#include <span>

#include "component/progress.hpp"
#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/lattice/moments_of_cell.hpp"

namespace copepod::fluid {

namespace {

Cell shifted(const Cell& cell, int direction) {
  const auto& e = d3q19::e[direction];
  return {cell[0] + e[0], cell[1] + e[1], cell[2] + e[2]};
}

/// Calls visit(ghost, direction) for every ghost cell and direction that enters `block`, in a fixed order.
template <class Visit>
void for_each_entering(const Box& block, const Visit& visit) {
  for (int direction = 1; direction < d3q19::directions; ++direction) {
    const auto& e = d3q19::e[direction];
    for (std::int64_t x = block.low[0] - e[0]; x < block.high[0] - e[0]; ++x) {
      for (std::int64_t y = block.low[1] - e[1]; y < block.high[1] - e[1]; ++y) {
        const bool row_inside =
            x >= block.low[0] && x < block.high[0] && y >= block.low[1] && y < block.high[1];
        if (!row_inside) {
          for (std::int64_t z = block.low[2] - e[2]; z < block.high[2] - e[2]; ++z)
            visit(Cell{x, y, z}, direction);
        } else if (e[2] != 0) {
          visit(Cell{x, y, e[2] > 0 ? block.low[2] - 1 : block.high[2]}, direction);
        }
      }
      report_progress();
    }
  }
}

/// Whether a ghost cell of `a` can stand for a cell of `b`: the boxes touch, perhaps through a periodic face.
bool touches(const Domain& domain, const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto near = [&](std::int64_t shift) {
      return a.low[axis] - 1 < b.high[axis] + shift && b.low[axis] + shift < a.high[axis] + 1;
    };
    const std::int64_t cells = domain.cells()[axis];
    if (!near(0) && !(domain.periodic(axis) && (near(cells) || near(-cells)))) return false;
  }
  return true;
}

}  // namespace

template <class T>
GhostExchange<T>::GhostExchange(const Domain& domain, const BlockPartition& partition,
                                const PopulationLayout& layout, Communicator& communicator,
                                const Eigen::Vector3d& body_force_lu)
    : layout_(layout), communicator_(communicator), half_force_(0.5 * body_force_lu) {
  for (int rank = 0; rank < partition.ranks(); ++rank)
    if (touches(domain, partition.block(rank), layout.block())) collect(domain, partition, layout, rank);
  for (Peer& peer : peers_) {
    peer.send_buffer.resize(static_cast<std::size_t>(peer.send[0].values()));
    peer.receive_buffer.resize(static_cast<std::size_t>(peer.receive[0].values()));
  }
  for (Peer& peer : peers_)
    messages_.push_back({peer.rank, std::as_bytes(std::span(peer.send_buffer)),
                         std::as_writable_bytes(std::span(peer.receive_buffer))});
}

template <class T>
typename GhostExchange<T>::Peer& GhostExchange<T>::peer(int rank) {
  const auto found =
      std::find_if(peers_.begin(), peers_.end(), [&](const Peer& p) { return p.rank == rank; });
  if (found != peers_.end()) return *found;
  peers_.emplace_back().rank = rank;
  return peers_.back();
}

/// What `rank` receives from us, or, for our own rank, what we receive from anyone and what our own faces
/// change.
template <class T>
void GhostExchange<T>::collect(const Domain& domain, const BlockPartition& partition,
                               const PopulationLayout& layout, int rank) {
  constexpr std::array placements = {Placement::home, Placement::streamed};
  const int self = communicator_.rank();
  const Box block = partition.block(rank);
  std::array<bool, 6> remote{};
  for_each_entering(block, [&](const Cell& ghost, int direction) {
    const GhostSource source = ghost_source(domain, ghost, direction);
    const int owner = partition.owner(source.cell);
    if (rank != self) {
      if (owner != self) return;
      for (int p = 0; p < 2; ++p)
        peer(rank).send[p].add(layout.location(layout.site(source.cell), source.direction, placements[p]));
      return;
    }
    const Site entered = layout.site(shifted(ghost, direction));
    if (owner != self) {
      for (int p = 0; p < 2; ++p) peer(owner).receive[p].add(layout.entry(entered, direction, placements[p]));
      for (int axis = 0; axis < 3; ++axis)
        if (source.cell[axis] < block.low[axis] || source.cell[axis] >= block.high[axis])
          remote[face_index(axis, ghost[axis] >= block.high[axis])] = true;
    } else if (source.kind == GhostSource::Kind::pressure) {
      pressure_.push_back({entered, direction, source.excess_density});
    } else if (source.addition != 0.0) {
      for (int p = 0; p < 2; ++p) {
        const std::int64_t entry = layout.entry(entered, direction, placements[p]);
        moving_walls_[p].add(entry, entry, source.addition);
      }
    }
  });
  if (rank == self) split_block(layout, remote);
}

template <class T>
void GhostExchange<T>::split_block(const PopulationLayout& layout, const std::array<bool, 6>& remote) {
  const Box& block = layout.block();
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

template <class T>
void GhostExchange<T>::start(T* populations, Placement placement) {
  const auto p = static_cast<std::size_t>(placement);
  for (Peer& peer : peers_) peer.send[p].pack(populations, peer.send_buffer.data());
  wait_ = communicator_.start_exchange(messages_);
  apply_pressure(populations, placement);  // first: it needs moments of populations that no wall has changed
  moving_walls_[p].copy(populations);
}

template <class T>
void GhostExchange<T>::finish(T* populations, Placement placement) {
  const auto p = static_cast<std::size_t>(placement);
  for (Peer& peer : peers_) peer.receive[p].unpack(populations, peer.receive_buffer.data());
}

/// Anti-bounce-back [Ginzburg, Verhaeghe, d'Humières 2008]: f_ᾱ(x_f) = −f̃_α(x_f) + 2 w_α ρ_w (1 + 9/2 (e·u)²
/// − 3/2 u²), with the velocity of the fluid cell for that of the face: u = (Σ f̃ e − F/2) / ρ, since a
/// collision adds half of the force F that belongs to the next half step [Guo, Zheng, Shi 2002]. f̃_α lies
/// where f_ᾱ will be read, so all of a cell's are computed before one is replaced.
template <class T>
void GhostExchange<T>::apply_pressure(T* populations, Placement placement) {
  entering_.clear();
  for (const PressureLink& link : pressure_) {
    const CellMoments m = moments_of_cell(populations, layout_, link.cell, placement);
    const auto& e = d3q19::e[link.direction];
    const double inverse_density = 1.0 / (1.0 + m.excess_density);
    const Eigen::Vector3d u = (m.momentum - half_force_) * inverse_density;
    const double eu = e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
    const double uu = u.squaredNorm();
    const double w = d3q19::weight(link.direction);
    const double leaving =
        populations[layout_.location(link.cell, d3q19::opposite(link.direction), placement)];
    const double entering =
        -leaving + 2.0 * w * (link.excess_density + (1.0 + link.excess_density) * (4.5 * eu * eu - 1.5 * uu));
    entering_.push_back(static_cast<T>(entering));
  }
  for (std::size_t i = 0; i < pressure_.size(); ++i)
    populations[layout_.entry(pressure_[i].cell, pressure_[i].direction, placement)] = entering_[i];
}

template class GhostExchange<float>;
template class GhostExchange<double>;

}  // namespace copepod::fluid
