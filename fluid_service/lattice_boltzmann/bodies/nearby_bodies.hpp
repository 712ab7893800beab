#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "contract/exchange.hpp"
#include "lattice_boltzmann/bodies/load_sums.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// How rank 0 reaches every rank by messages of their own: rank r sends to 32 r + 1 … 32 r + 32. One rank of 32 relays,
/// and these are the first ones: where there are many bodies they have fewer cells (block_partition.hpp), and receive
/// while the others compute.
constexpr int relay_base = 32;

/// The rank from which `rank`, which is not 0, receives.
constexpr int relay_before(int rank) { return (rank - 1) / relay_base; }

/// `rank` and those that it relays to, each followed by the ones behind it.
inline std::vector<int> ranks_behind(int rank, int ranks) {
  std::vector<int> result = {rank};
  const std::int64_t first = std::int64_t{relay_base} * rank + 1;
  for (std::int64_t next = first; next < std::min<std::int64_t>(first + relay_base, ranks); ++next) {
    const std::vector<int> behind = ranks_behind(static_cast<int>(next), ranks);
    result.insert(result.end(), behind.begin(), behind.end());
  }
  return result;
}

/// A rank that is sent to directly, and the places in ranks_behind of it and those behind it: [first, end).
struct Relay {
  int rank = 0;
  std::size_t first = 0;
  std::size_t end = 0;
};

/// @param behind  ranks_behind of a rank
inline std::vector<Relay> relays_after(const std::vector<int>& behind) {
  std::vector<Relay> result;
  for (std::size_t place = 1; place < behind.size(); ++place) {
    if (relay_before(behind[place]) == behind.front()) result.push_back({behind[place], place, place});
    result.back().end = place + 1;
  }
  return result;
}

/// Blocks that are neighbours: `count` of them along each axis, from `first` on; around the end of a periodic axis.
struct BlockRange {
  std::array<int, 3> first{};
  std::array<int, 3> count{};  ///< 0: none

  bool operator==(const BlockRange&) const = default;
};

/// The blocks that a body may have to do with: those with cells within its bounding ball or up to a margin from it.
class NearBlocks {
 public:
  struct Found {
    BlockRange blocks;
    Eigen::AlignedBox3d stays_lu;  ///< while the centre is in there they are the same
  };

  /// @param film_reach_lu  surfaces so far from a surface matter to its links
  NearBlocks(const Domain& domain, const BlockPartition& partition, double film_reach_lu);

  /// @param position_lu         of the centre; outside the domain the nearest cell counts, if not finite the first one
  /// @param bounding_radius_lu  of the body
  [[nodiscard]] Found around(const Eigen::Vector3d& position_lu, double bounding_radius_lu) const;

  /// visit(rank) for those of `range` that are not in `except`.
  template <class Visit>
  void for_each_rank(const BlockRange& range, const BlockRange& except, const Visit& visit) const {
    const auto place = [&](int axis, int step) {
      const int at = range.first[axis] + step;
      return at < grid_[axis] ? at : at - grid_[axis];
    };
    for (int i = 0; i < range.count[0]; ++i)
      for (int j = 0; j < range.count[1]; ++j)
        for (int k = 0; k < range.count[2]; ++k) {
          const std::array<int, 3> at = {place(0, i), place(1, j), place(2, k)};
          if (contains(except, 0, at[0]) && contains(except, 1, at[1]) && contains(except, 2, at[2])) continue;
          visit((at[0] * grid_[1] + at[1]) * grid_[2] + at[2]);
        }
  }

 private:
  [[nodiscard]] bool contains(const BlockRange& range, int axis, int place) const {
    const int steps = place - range.first[axis];
    return (steps < 0 ? steps + grid_[axis] : steps) < range.count[axis];
  }

  const Domain& domain_;
  std::array<int, 3> grid_;
  double margin_lu_;
  std::array<std::vector<double>, 3> starts_;  ///< of blocks along an axis, and the end; −∞ and ∞ if not periodic
};

/// Sends each rank what it needs of the bodies near its block, and brings to rank 0 what the rank finds to act on them.
/// A body that leaves a rank is sent there once more, so that it gives up its cells. What a rank sends and receives
/// depends on the bodies near it, and for one that relays (relay_base) on those near the ranks behind it; only rank 0
/// has to do with all bodies. It keeps the list of each rank, and searches only where a body comes near other ranks.
///
/// One step, collective: scatter -> gather -> finish
class NearbyBodies {
 public:
  /// @param returns_mass  bodies give mass back, which only rank 0 has
  NearbyBodies(const FluidSetup& setup, const LatticeUnits& units, const Domain& domain,
               const BlockPartition& partition, bool returns_mass, Communicator& communicator);

  /// @param kinematics     on rank 0: of all bodies; on other ranks: ignored
  /// @param returned_mass  on rank 0: by body, if bodies return mass
  /// @throws SolverError for another number of bodies than that of the setup
  void scatter(const Kinematics& kinematics, std::span<const double> returned_mass);

  /// On rank 0: what was last scattered, read from the messages. Orientations only if one of the shapes has one.
  [[nodiscard]] Kinematics all_kinematics() const;
  /// The bodies near this rank, ascending.
  [[nodiscard]] const std::vector<std::int32_t>& bodies() const { return bodies_; }
  /// Of these bodies. Orientations only if one of the shapes has one.
  [[nodiscard]] const Kinematics& kinematics() const { return kinematics_; }
  /// By place in bodies(): mass that the body gives back, by the weight of its links.
  [[nodiscard]] const std::vector<double>& returned_mass() const { return returned_mass_; }
  /// Place in bodies() of one of them.
  [[nodiscard]] std::size_t place_of(std::int32_t body) const;

  /// @param loads   of this rank, by place in bodies()
  /// @param gained  of this rank; on return, on rank 0: of all ranks
  void gather(std::span<const LoadSums> loads, MomentumSums& gained);
  /// On rank 0: what was gathered from all ranks, of a body of the setup.
  [[nodiscard]] fixed_point::Sum total(std::size_t body, std::size_t component) const {
    const std::size_t at = body * components_ + component;
    return total_low_[at] + (total_high_.empty() ? 0 : fixed_point::Sum{total_high_[at]} << 64);
  }

  /// Waits until the other ranks have received what this one sent.
  void finish();

 private:
  void update_lists(const Eigen::Matrix3Xd& position_m);
  void write_section(std::size_t place, const Kinematics& kinematics, std::span<const double> returned_mass);
  std::byte* write_record(std::byte* to, const Kinematics& kinematics, std::int32_t body,
                          std::span<const double> returned_mass) const;
  void find_sections();
  void take_own_section();
  const std::byte* take_record(const std::byte* from, Kinematics& kinematics, Eigen::Index column,
                               double& returned_mass) const;
  void append_loads(std::int32_t body, const LoadSums& sums);
  void add_loads(std::span<const std::byte> message, MomentumSums& gained);
  void add_to_total(std::size_t at, fixed_point::Sum value);
  void add_to_high(std::size_t at, std::int64_t value);

  Communicator& communicator_;
  LatticeUnits units_;
  NearBlocks near_blocks_;
  std::vector<double> bounding_radius_lu_;
  bool has_orientations_;
  bool returns_mass_;
  std::size_t record_bytes_;
  std::size_t components_;   ///< of loads, that are of use on rank 0
  std::vector<int> behind_;  ///< this rank and those that it relays to
  std::vector<Relay> relays_;

  // On rank 0: which blocks each body is near, and where its centre may be before they are others [m]; by rank, the
  // bodies it is sent; rank and body where this is for the last time.
  std::vector<BlockRange> near_;
  std::vector<Eigen::AlignedBox3d> stays_m_;
  std::vector<std::vector<std::int32_t>> listed_;
  std::vector<std::pair<int, std::int32_t>> leaving_;
  // For each rank of behind_: number of records, records.
  std::vector<std::byte> records_;
  std::vector<std::size_t> section_starts_;

  std::vector<std::int32_t> bodies_;
  Kinematics kinematics_;
  std::vector<double> returned_mass_;

  std::vector<std::byte> loads_;     ///< to be sent: gained momentum, then the loads of bodies
  std::vector<std::byte> received_;  ///< likewise
  // On rank 0, by body and component: sums low + 2⁶⁴ high; no high ones as long as all are 0.
  std::vector<std::int64_t> total_low_;
  std::vector<std::int64_t> total_high_;
  std::vector<std::function<void()>> sends_;
};

}  // namespace copepod::fluid
