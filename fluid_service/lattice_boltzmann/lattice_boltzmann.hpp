#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "contract/solver.hpp"
#include "contract/timeline.hpp"
#include "lattice_boltzmann/bodies/momentum_exchange.hpp"
#include "lattice_boltzmann/bodies/nearby_bodies.hpp"
#include "lattice_boltzmann/bodies/refill.hpp"
#include "lattice_boltzmann/boundary/halo_exchange.hpp"
#include "lattice_boltzmann/boundary/open_faces.hpp"
#include "lattice_boltzmann/boundary/wall.hpp"
#include "lattice_boltzmann/kernel/stream_collide.hpp"
#include "lattice_boltzmann/lattice/huge_array.hpp"
#include "lattice_boltzmann/lattice/initial_flow.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"
#include "lattice_boltzmann/output/field_output.hpp"
#include "lattice_boltzmann/output/flow_sampler.hpp"
#include "lattice_boltzmann/output/population_file.hpp"

namespace copepod::fluid {

/// Phases of a step, in the order in which they happen.
enum class Phase { map, refill, momentum, reduce, halo, wait, bulk, check, output, summary };

/// Wall time per phase: each call books the time since the previous one, and adds it to the timeline.
class PhaseTimer {
 public:
  explicit PhaseTimer(Timeline& timeline) : timeline_(timeline) {}
  void start() { last_ = Clock::now(); }
  void book(Phase phase) {
    const auto now = Clock::now();
    seconds_[static_cast<int>(phase)] += std::chrono::duration<double>(now - last_).count();
    timeline_.add(names[static_cast<int>(phase)], last_, now);
    last_ = now;
  }
  [[nodiscard]] std::map<std::string, double> seconds() const {
    std::map<std::string, double> result;
    for (int i = 0; i < phases; ++i) result[names[i]] = seconds_[i];
    return result;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int phases = static_cast<int>(Phase::summary) + 1;
  static constexpr const char* names[phases] = {"map",  "refill", "momentum", "reduce", "halo",
                                                "wait", "bulk",   "check",    "output", "summary"};
  Timeline& timeline_;
  Clock::time_point last_ = Clock::now();
  double seconds_[phases] = {};
};

/// One rank's share of the lattice Boltzmann fluid. Every method is collective: called on all ranks with the
/// same arguments, apart from kinematics, which are read on rank 0; loads and summaries are valid there. A flow that
/// diverged is a SolverError: from advance within 1024 steps, from fields, save and summarise at once.
///
/// One step, with populations stored in place (lattice/population_layout.hpp):
///   exchange: kinematics to the ranks near each body -> map these -> refill uncovered cells -> links
///             -> momentum exchange -> sum the loads
///   advance:  domain faces, other ranks' populations -> reflected populations -> stream and collide -> collect
/// Link formulas that use a second cell need other ranks' populations before the momentum exchange.
template <class T>
class LatticeBoltzmann final : public FluidSolver {
 public:
  LatticeBoltzmann(const FluidSetup& setup, Communicator& communicator);

  void exchange(const Kinematics& kinematics, Loads& loads) override;
  void advance() override;
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

  [[nodiscard]] const Domain& domain() const { return domain_; }
  [[nodiscard]] std::int64_t step() const { return step_; }
  /// Macroscopic fields of cells of this rank, SI units.
  [[nodiscard]] FieldBlock fields(const Box& box) const;
  [[nodiscard]] FieldBlock fields() const { return fields(layout_.block()); }
  /// Starts every cell from `flow(cell)`, a LocalFlow.
  template <class Flow>
  void initialise(const Flow& flow) {
    const double relaxation_time = units_.relaxation_time(setup_.kinematic_viscosity_m2_per_s);
    const Eigen::Vector3d force = units_.body_force_lu(setup_.body_force_N_per_m3);
    for_each_cell(layout_.block(), [&](const Cell& cell) {
      LocalFlow local = flow(cell);
      local.force = force;
      for (int alpha = 0; alpha < d3q19::directions; ++alpha)
        populations_[layout_.location(layout_.site(cell), alpha, placement_)] =
            static_cast<T>(starting_deviation(alpha, local, relaxation_time));
    });
    links_.forget_populations();
  }

 private:
  void start_from_file();
  void map_bodies(const Kinematics& kinematics);
  void count_changed_cells();
  /// Mass that each body gives back in this step, by the weight of its links; on rank 0.
  [[nodiscard]] std::vector<double> returned_mass() const;
  void sum_loads(const Kinematics& kinematics, Loads& loads);
  void report_loads(const Kinematics& kinematics, Loads& loads);
  [[nodiscard]] double total_lu(Eigen::Index body, std::size_t component) const {
    return fixed_point::to_double(nearby_.total(body, component));
  }
  void start_halo() {
    halo_.start(populations_.data(), placement_);
    timer_.book(Phase::halo);
  }
  void receive_halo();
  /// As OpenFaces::for_each_entering; needs the halo.
  template <class Visit>
  void for_each_let_in(const Visit& visit);
  void visit_crossings(const FlowSampler::VisitCrossing& visit);
  void update(const Box& region);
  /// visit(index into populations_) for the cells of a piece (x, y, z), z fastest, and their 19 directions.
  template <class Visit>
  void for_each_population(const Box& piece, Placement placement, const Visit& visit) const;
  void check_rows() const;
  void check_all_rows() const;
  void check_row(std::int64_t x, std::int64_t y) const;
  [[nodiscard]] Moments<double> moments_of(const Site& site) const {
    return moments(layout_.gather(populations_.data(), site, placement_));
  }
  [[nodiscard]] Moments<double> checked_moments(const Cell& cell) const;
  struct Total {
    std::uint64_t digest = 0;
    fixed_point::Sum excess_mass = 0;
  };
  [[nodiscard]] Total total_of_cells() const;
  [[nodiscard]] std::optional<double> momentum_drift() const;
  /// For loops over the block that take long.
  [[nodiscard]] auto showing_progress() const {
    return [this] { communicator_.context().report_progress(); };
  }

  FluidSetup setup_;
  Communicator& communicator_;
  LatticeUnits units_;
  Domain domain_;
  BlockPartition partition_;
  PopulationLayout layout_;
  HugeArray<T> populations_;
  CollisionConstants<T> constants_;
  bool has_force_;
  StreamCollide<T> stream_collide_;
  HaloExchange<T> halo_;
  MovingWalls moving_walls_;
  OpenFaces open_faces_;
  BodyMap map_;
  std::unique_ptr<Refiller<T>> refill_;
  ThinFilms films_;
  std::unique_ptr<MomentumExchange<T>> exchange_momentum_;
  BoundaryLinks<T> links_;
  NearbyBodies nearby_;
  std::vector<LoadSums> load_sums_;  ///< of this rank, by place in nearby_
  MomentumSums gained_momentum_{};   ///< of this step, from neither body, wall nor force
  // On rank 0, of all bodies:
  Eigen::Matrix2Xd absorbed_mass_;  ///< by body: mass absorbed and not yet given back, weight of its links
  MomentumBalance momentum_;        ///< of the computed domain, up to the last exchange
  Placement placement_ = Placement::home;
  bool has_halo_ = false;  ///< populations of other ranks are there for the next update
  std::int64_t step_ = 0;  ///< steps completed
  PhaseTimer timer_;
  FieldSchedule output_;
  FlowSampler sample_flow_;
};

/// The rank solver for the precision that the setup asks for.
std::unique_ptr<FluidSolver> make_lattice_boltzmann(const FluidSetup& setup, Communicator& communicator);

/// Peak memory of the solver on the rank with the largest block [bytes]: populations with ghosts and padding,
/// the map of bodies, messages to other ranks, and copies of the fields while they are written.
/// docs/results/memory.md compares it with measurements; bodies and checkpoints add less than their error.
/// @throws CaseError for a domain that cannot be computed, or cannot be cut into so many blocks
std::int64_t estimate_lattice_boltzmann_bytes(const FluidSetup& setup, int ranks);

}  // namespace copepod::fluid
