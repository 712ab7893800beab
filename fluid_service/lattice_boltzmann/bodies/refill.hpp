#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

#include "contract/errors.hpp"
#include "lattice_boltzmann/bodies/body_map.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

// Refill formulas: the populations of a cell that a body has uncovered, from its fluid neighbours. Each is a
// type with `Neighbour` (what a neighbour contributes), `describe` (a neighbour's populations f̃_α − w_α) and
// `fill` (its means over the neighbours, all zero without any, and u_w = U + Ω × r at the cell);
// make_refiller picks the one named in the case.

namespace copepod::fluid {

/// Equilibrium with the surface velocity of the body that left and the mean density of the neighbours
/// [paper, section 2.3].
struct EquilibriumRefill {
  using Neighbour = std::array<double, 1>;  ///< excess density

  static Neighbour describe(const Populations& f) { return {moments(f).excess_density}; }
  static Populations fill(const Neighbour& mean, const Eigen::Vector3d& u_w) { return equilibrium(mean[0], u_w); }
};

/// The same and the mean non-equilibrium part of the neighbours, f̃_α − f_α^{eq} [Caiazzo 2008, there of the
/// neighbour along the normal].
struct NonequilibriumRefill {
  using Neighbour = std::array<double, 1 + d3q19::directions>;  ///< excess density, f̃_α − f_α^{eq}

  static Neighbour describe(const Populations& f) {
    const Moments<double> m = moments(f);
    const Populations at_rest = equilibrium(m.excess_density, m.momentum_vector() / (1.0 + m.excess_density));
    Neighbour result{m.excess_density};
    for (std::size_t alpha = 0; alpha < f.size(); ++alpha) result[1 + alpha] = f[alpha] - at_rest[alpha];
    return result;
  }
  static Populations fill(const Neighbour& mean, const Eigen::Vector3d& u_w) {
    Populations f = equilibrium(mean[0], u_w);
    for (std::size_t alpha = 0; alpha < f.size(); ++alpha) f[alpha] += mean[1 + alpha];
    return f;
  }
};

/// Equilibrium and the populations that carry the mean stress Π of the neighbours, without higher moments
/// [Grad's approximation: Chikatamarla, Ansumali, Karlin 2006; Latt et al. 2008]:
///   f_α = f_α^{eq} + 9/2 w_α (e_α e_α − I/3) : Π,   Π = Σ_α e_α e_α (f̃_α − f_α^{eq})
struct GradRefill {
  using Neighbour = std::array<double, 7>;  ///< excess density, Π_xx, Π_yy, Π_zz, Π_xy, Π_yz, Π_zx

  static Neighbour describe(const Populations& f) {
    const NonequilibriumRefill::Neighbour all = NonequilibriumRefill::describe(f);
    const auto even = [&](int alpha) {  // pairs first: the same for a cell and its mirror image
      const auto place = 1 + static_cast<std::size_t>(alpha);
      return all[place] + all[place + 1];
    };
    Neighbour result{all[0], even(1), even(3), even(5)};
    for (int alpha = 7; alpha < d3q19::directions; alpha += 4) {  // the diagonals of a plane
      const auto& e = d3q19::e[alpha];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t next = (axis + 1) % 3;
        result[1 + axis] += e[axis] * e[axis] * (even(alpha) + even(alpha + 2));
        if (e[axis] * e[next] != 0) result[4 + axis] = e[axis] * e[next] * (even(alpha) - even(alpha + 2));
      }
    }
    return result;
  }
  static Populations fill(const Neighbour& mean, const Eigen::Vector3d& u_w) {
    Populations f = equilibrium(mean[0], u_w);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      const auto& e = d3q19::e[alpha];
      double product = -(mean[1] + mean[2] + mean[3]) / 3.0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        product += e[axis] * e[axis] * mean[1 + axis] + 2.0 * e[axis] * e[(axis + 1) % 3] * mean[4 + axis];
      f[alpha] += 4.5 * d3q19::weight(alpha) * product;
    }
    return f;
  }
};

/// Gives uncovered cells their populations, by a refill formula. Cells uncovered in the
/// same step do not count as neighbours.
///
/// What neighbours on other ranks contribute travels only in steps in which a cell beside the border is
/// uncovered: both sides derive the size and order of the message from their own maps.
template <class T>
class Refiller {
 public:
  virtual ~Refiller() = default;

  /// Refills the cells of `map.uncovered()` that this rank owns; collective.
  virtual void operator()(T* populations, Placement placement, const BodyMap& map) = 0;
};

template <class Formula, class T>
class RefillerBy final : public Refiller<T> {
 public:
  RefillerBy(const Domain& domain, const BlockPartition& partition, const PopulationLayout& layout,
             Communicator& communicator)
      : domain_(domain), partition_(partition), layout_(layout), communicator_(communicator) {}

  void operator()(T* populations, Placement placement, const BodyMap& map) override {
    if (map.uncovered().empty()) return;
    look_around(populations, placement, map);
    exchange_neighbours();
    for (Uncovered& uncovered : uncovered_) fill(populations, placement, map, uncovered);
  }

 private:
  using Neighbour = typename Formula::Neighbour;

  struct Uncovered {
    const BodyMap::ChangedCell* cell = nullptr;
    std::vector<Neighbour> neighbours;
  };
  /// A neighbour that one rank offers and another one needs.
  struct Request {
    int rank = 0;
    std::int64_t uncovered = 0;  ///< linear index of the uncovered domain cell
    std::int64_t neighbour = 0;  ///< linear index of the domain cell beside it
    std::size_t place = 0;       ///< in uncovered_, where it is needed
    Neighbour value{};
    bool operator<(const Request& other) const {
      return std::tie(rank, uncovered, neighbour) < std::tie(other.rank, other.uncovered, other.neighbour);
    }
  };

  [[nodiscard]] std::int64_t linear(const Cell& cell) const {
    const Cell& cells = domain_.cells();
    return (cell[0] * cells[1] + cell[1]) * cells[2] + cell[2];
  }

  /// Collects the neighbours that this rank has, those that it needs, and those that others need from it.
  void look_around(const T* populations, Placement placement, const BodyMap& map) {
    uncovered_.clear();
    needed_.clear();
    offered_.clear();
    // A cell of ours, mirrored as the other cell of the pair is if that is an image.
    const auto describe = [&](const Cell& cell, const Cell& image) {
      const Site site = layout_.site(cell);
      Populations f;
      for (int alpha = 0; alpha < d3q19::directions; ++alpha)
        f[alpha] = populations[layout_.location(site, domain_.mirrored(alpha, image), placement)];
      return Formula::describe(f);
    };
    const Box& block = layout_.block();
    for (const BodyMap::ChangedCell& uncovered : map.uncovered()) {
      const Cell cell = uncovered.cell();
      const bool ours = block.contains(cell);
      const Cell domain_cell = domain_.canonical(cell).value();
      const int rank = partition_.owner(domain_cell);
      if (!ours && rank == communicator_.rank()) continue;  // an image of a cell of ours, which is in the list itself
      if (ours) uncovered_.push_back({&uncovered, {}});
      for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
        const auto& e = d3q19::e[alpha];
        const Cell neighbour = {cell[0] + e[0], cell[1] + e[1], cell[2] + e[2]};
        if (!ours && !block.contains(neighbour)) continue;
        const auto source = domain_.canonical(neighbour);
        if (!source || map.owner(layout_.cell(neighbour)) != BodyMap::fluid) continue;
        const int source_rank = partition_.owner(*source);
        if (!ours) {
          offered_.push_back({rank, linear(domain_cell), linear(*source), 0, describe(neighbour, cell)});
        } else if (source_rank != communicator_.rank()) {
          needed_.push_back({source_rank, linear(domain_cell), linear(*source), uncovered_.size() - 1, {}});
        } else {
          uncovered_.back().neighbours.push_back(describe(*source, neighbour));
        }
      }
    }
  }

  void exchange_neighbours() {
    if (needed_.empty() && offered_.empty()) return;
    std::sort(needed_.begin(), needed_.end());
    std::sort(offered_.begin(), offered_.end());
    struct Buffers {
      std::vector<Neighbour> send;
      std::vector<Neighbour> receive;
    };
    std::map<int, Buffers> peers;
    for (const Request& request : offered_) peers[request.rank].send.push_back(request.value);
    for (const Request& request : needed_) peers[request.rank].receive.push_back({});
    std::vector<Communicator::Message> messages;
    messages.reserve(peers.size());
    for (auto& [rank, buffers] : peers)
      messages.push_back(
          {rank, std::as_bytes(std::span(buffers.send)), std::as_writable_bytes(std::span(buffers.receive))});
    communicator_.start_exchange(messages)();

    std::map<int, std::size_t> next;
    for (const Request& request : needed_)
      uncovered_[request.place].neighbours.push_back(peers[request.rank].receive[next[request.rank]++]);
  }

  /// Each number is added up in the order of its values, which does not depend on the ranks.
  static Neighbour mean(std::span<const Neighbour> neighbours) {
    Neighbour result{};
    std::vector<double> values;
    for (std::size_t i = 0; i < result.size() && !neighbours.empty(); ++i) {
      values.clear();
      for (const Neighbour& neighbour : neighbours) values.push_back(neighbour[i]);
      std::ranges::sort(values);
      result[i] = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    }
    return result;
  }

  void fill(T* populations, Placement placement, const BodyMap& map, Uncovered& uncovered) const {
    const Cell cell = uncovered.cell->cell();
    const std::int32_t body_index = uncovered.cell->body;
    const LatticeBody& body = map.bodies()[body_index];
    const Populations filled =
        Formula::fill(mean(uncovered.neighbours), body.surface_velocity(domain_.from_position(body.position, cell)));
    const Site site = layout_.site(cell);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      populations[layout_.location(site, alpha, placement)] = static_cast<T>(filled[alpha]);
  }

  const Domain& domain_;
  const BlockPartition& partition_;
  const PopulationLayout& layout_;
  Communicator& communicator_;
  std::vector<Uncovered> uncovered_;
  std::vector<Request> needed_;
  std::vector<Request> offered_;
};

/// With the refill formula of a case. @throws CaseError for one that this version does not have
template <class T>
std::unique_ptr<Refiller<T>> make_refiller(Refill formula, const Domain& domain, const BlockPartition& partition,
                                           const PopulationLayout& layout, Communicator& communicator) {
  switch (formula) {
    case Refill::equilibrium:
      return std::make_unique<RefillerBy<EquilibriumRefill, T>>(domain, partition, layout, communicator);
    case Refill::nonequilibrium:
      return std::make_unique<RefillerBy<NonequilibriumRefill, T>>(domain, partition, layout, communicator);
    case Refill::grad:
      return std::make_unique<RefillerBy<GradRefill, T>>(domain, partition, layout, communicator);
  }
  throw CaseError("unknown refill (a newer coupler?). Use equilibrium.");
}

}  // namespace copepod::fluid
