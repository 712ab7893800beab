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
#include "lattice_boltzmann/bodies/refill_formula.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Gives uncovered cells their populations, by a refill formula (refill_formula.hpp). Cells uncovered in the
/// same step do not count as neighbours.
///
/// What neighbours on other ranks contribute travels only in steps in which a cell beside the border is
/// uncovered: both sides derive the size and order of the message from their own maps.
template <class T>
class Refiller {
 public:
  Refiller() = default;
  Refiller(const Refiller&) = delete;
  Refiller& operator=(const Refiller&) = delete;
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
        f[static_cast<std::size_t>(alpha)] =
            populations[layout_.location(site, domain_.mirrored(alpha, image), placement)];
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
    const LatticeBody& body = map.bodies()[static_cast<std::size_t>(body_index)];
    const Populations filled =
        Formula::fill(mean(uncovered.neighbours), body.surface_velocity(domain_.from_position(body.position, cell)));
    const Site site = layout_.site(cell);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      populations[layout_.location(site, alpha, placement)] = static_cast<T>(filled[static_cast<std::size_t>(alpha)]);
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
