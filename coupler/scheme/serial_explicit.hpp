#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "config/sections/case.hpp"
#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "contract/timeline.hpp"
#include "driving/driving_protocol.hpp"
#include "observers/observer.hpp"
#include "scheme/lubrication.hpp"

namespace copepod::coupler {

/// Mass and inertia by which the coupling enlarges light bodies, and the loads that make up for them one step later, so
/// that every body component computes the motion of the true masses:
///   (M + m)(V(n+1) − V(n)) = Δt F̄(n) + p(n) − p(n−1),   p = m V
///   L'(n+1) − L'(n) = Δt T̄(n) + h(n) − h(n−1),   L' = R (I + J) Rᵀ ω,   h = R J Rᵀ ω          [docs/theory.md, (C19)]
/// It is distributed evenly in the body, J = I m/M if that is uniform. The weight stays that of M. What is kept, p = h
/// = 0, makes the step of the drag implicit: bodies lose their momentum over a few steps, however short the time they
/// need for it.
class VirtualMass {
 public:
  /// No body has one.
  VirtualMass() = default;

  /// @param setup      the true bodies
  /// @param mass_kg    virtual mass m of each body; 0: none
  /// @param averaging  of the loads of bodies with a virtual mass; none: F̄(n) = F(n), even where those of other bodies
  ///                   are averaged
  /// @param returns    whether loads make up for them
  VirtualMass(const BodySetup& setup, const std::vector<double>& mass_kg, LoadAveraging averaging, bool returns = true);

  /// The setup to send to the body component: with masses M + m.
  [[nodiscard]] BodySetup enlarged(BodySetup setup) const;

  /// Bodies whose loads are not to be averaged, ascending.
  [[nodiscard]] const std::vector<Eigen::Index>& not_averaged() const { return not_averaged_; }

  /// Adds what the virtual masses gave to the fluid's loads, (p(n) − p(n−1))/Δt − m g and (h(n) − h(n−1))/Δt.
  /// In the first step p(n−1) = p(n).
  /// @param kinematics  of step n; steps must come in order
  /// @param loads       of that step
  void add_to(Loads& loads, const Kinematics& kinematics);

  /// Whether it has a state, the kinematics of the step before.
  [[nodiscard]] bool remembers() const { return returns_ && !additions_.empty(); }

  /// Kinematics of the step before, all that is needed to continue bit for bit; no bodies: none yet, or none needed.
  [[nodiscard]] const Kinematics& previous() const { return previous_; }
  void restore(const Kinematics& previous) { previous_ = previous; }

 private:
  struct Addition {
    Eigen::Index body = 0;
    double mass_kg = 0.0;
    Eigen::Matrix3d inertia_kg_m2;  ///< J in the frame of the body
    Eigen::Vector3d weight_N;       ///< m g
  };

  std::vector<Addition> additions_;
  std::vector<Eigen::Index> not_averaged_;
  double step_s_ = 0.0;
  bool returns_ = true;
  Kinematics previous_;
};

/// Judges the motion that a body component reports, whatever fluid it is coupled to: a run whose bodies have
/// left the domain must not finish as if nothing had happened.
class Plausibility {
 public:
  /// @param bodies         names, shapes, initial positions, in the order of Kinematics; must outlive this object
  /// @param largest_speed_m_per_s  of a body's surface [m/s]: what the fluid can follow
  Plausibility(const FluidSetup& fluid, const std::vector<BodySpecification>& bodies,
               double largest_speed_m_per_s = std::numeric_limits<double>::infinity());

  /// A body must be inside the domain (its centre, and only if it began there), must neither move by more than its
  /// radius nor turn by more than one radian in a step, and its orientation must be a unit quaternion. Its surface
  /// must not be faster than the fluid can follow.
  /// @param after  state that follows `before` by one step
  /// @throws PeerFailed in the name of the body component, with body, step and value; numbers that are not
  /// finite fail
  void judge(const Kinematics& before, const Kinematics& after) const;

  /// Whether a body is where bodies are that left through an outflow: what a component reports of them is not judged.
  [[nodiscard]] bool is_removed(const Eigen::Vector3d& position_m) const;

 private:
  const std::vector<BodySpecification>& bodies_;
  double largest_speed_m_per_s_;
  Eigen::Vector3d length_m_ = Eigen::Vector3d::Zero();  ///< of the domain; 0: unknown
  std::array<Boundary, 6> boundaries_;
  std::array<bool, 3> periodic_{};
  std::vector<std::array<bool, 3>> confined_;  ///< by body and axis
};

/// Adds up wall time over many short intervals, each of which is a phase of the timeline too.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param timeline  outlives this object
  /// @param phase     its name in the timeline; a literal
  Stopwatch(Timeline& timeline, std::string_view phase) : timeline_(timeline), phase_(phase) {}

  /// Runs `work` and adds the time it took.
  template <typename Work>
  void time(Work&& work) {
    const Clock::time_point start = Clock::now();
    work();
    const Clock::time_point end = Clock::now();
    total_ += end - start;
    timeline_.add(phase_, start, end);
  }
  [[nodiscard]] double seconds() const { return std::chrono::duration<double>(total_).count(); }

 private:
  Timeline& timeline_;
  std::string_view phase_;
  Clock::duration total_{};
};

/// Loads that the bodies receive, computed from those that the fluid returns.
///   two_step:  F̄(n) = (F(n) + F(n−1)) / 2,   F̄(0) = F(0) / 2        [docs/theory.md, (C3); Ladd 1994]
///   none:      F̄(n) = F(n)
/// Averaging removes the step-to-step oscillation that the explicit coupling grows with light bodies. Bodies receive
/// all that the fluid gives, half a step late: no load counts twice, not even the large one of a sudden start.
class LoadAverage {
 public:
  /// @param not_averaged  bodies whose loads stay as they are
  explicit LoadAverage(LoadAveraging kind, std::vector<Eigen::Index> not_averaged = {})
      : kind_(kind), not_averaged_(std::move(not_averaged)) {}

  /// @param raw      loads of step n; steps must come in order
  /// @param applied  overwritten with the loads to apply in step n
  void apply(const Loads& raw, Loads& applied);

  [[nodiscard]] bool averages() const { return kind_ != LoadAveraging::none; }

  /// Raw loads of the step before, all that is needed to continue bit for bit; empty before the first step.
  [[nodiscard]] const Loads& previous() const { return previous_; }
  void restore(const Loads& previous) { previous_ = previous; }

 private:
  LoadAveraging kind_;
  std::vector<Eigen::Index> not_averaged_;
  Loads previous_;
};

/// Serial explicit coupling of one fluid and one body solver [paper, Algorithm 2]: fluid and bodies take
/// turns, each once per step, and nothing is iterated.
///
/// Legal call order: construct -> [restore] -> { run }* -> finish; references must outlive the scheme. An exception of
/// a solver leaves the scheme unusable.
class SerialExplicit {
 public:
  SerialExplicit(FluidSolver& fluid, BodySolver& body, const DrivingProtocol& driving, const Plausibility& plausibility,
                 LoadAveraging averaging, Observer& observer, Timeline& timeline, VirtualMass virtual_mass = {},
                 Lubrication lubrication = {}, Controllers controllers = {});

  /// Advances to the start of step `stop`, or of the first step before which `pause` returns true.
  /// @param pause  asked before every step
  /// @throws what a solver, an observer or `pause` throws, and PeerFailed for a motion that is not plausible
  void run(std::int64_t stop, const std::function<bool(std::int64_t step)>& pause);

  /// Loads and kinematics of the step before, which averaging and virtual masses need: with the solvers' states all
  /// there is to save.
  [[nodiscard]] const Loads& previous_loads() const { return averaging_.previous(); }
  [[nodiscard]] const Kinematics& previous_kinematics() const { return virtual_mass_.previous(); }
  /// @param step  to which the solvers have been restored
  /// @throws StorageError if the parts do not belong together
  /// @param loads  those of `loads`; of no bodies: unknown
  void restore(std::int64_t step, const Loads& previous_loads, const Kinematics& previous_kinematics,
               const Loads& loads = {});

  /// Hands the final state to the observer.
  void finish_to(Observer& observer) const {
    observer.finish({step_, kinematics_, loads_, averaged_, drive_, obstacle_loads_});
  }
  void finish() { finish_to(observer_); }

  /// Step that comes next, and the state of motion at its start.
  [[nodiscard]] std::int64_t step() const { return step_; }
  [[nodiscard]] const Kinematics& kinematics() const { return kinematics_; }
  /// Hydrodynamic loads on the bodies during the step before; zeros before the first.
  [[nodiscard]] const Loads& loads() const { return loads_; }
  [[nodiscard]] const Controllers& controllers() const { return controllers_; }

  /// Seconds spent waiting for each solver.
  [[nodiscard]] double fluid_wait_s() const { return fluid_watch_.seconds(); }
  [[nodiscard]] double body_wait_s() const { return body_watch_.seconds(); }

 private:
  void split_loads();
  void couple();

  FluidSolver& fluid_;
  BodySolver& body_;
  const DrivingProtocol& driving_;
  const Plausibility& plausibility_;
  LoadAverage averaging_;
  VirtualMass virtual_mass_;
  Lubrication lubrication_;
  Controllers controllers_;
  Observer& observer_;
  Timeline& timeline_;
  std::vector<double> nodes_;

  std::int64_t step_ = 0;
  Kinematics kinematics_;
  Kinematics next_;
  Loads loads_;
  Loads obstacle_loads_;
  Eigen::VectorXd flow_;  ///< newest sample
  Loads averaged_;
  AppliedLoads applied_;
  Loads drive_;  ///< at the start of the step
  Stopwatch fluid_watch_{timeline_, "wait for fluid"};
  Stopwatch couple_watch_{timeline_, "couple"};
  Stopwatch body_watch_{timeline_, "wait for bodies"};
};

}  // namespace copepod::coupler
