#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "analysis/cycle.hpp"
#include "config/sections/case.hpp"
#include "config/sections/sections.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

/// The swimmers of a case, then its groups, as the analysis sees them. Arms are the springs between their bodies.
///
/// The period is that of all periodic signals on a swimmer's bodies. If they differ, it is, with a note, their least
/// common multiple, or the longest of them where that is more than ten times as long. Cycles count that lie between the
/// first start of these signals and the first stop.
std::vector<Group> groups_of(const Case& the_case, const Assembly& assembly);

/// Whether any has a period.
bool have_cycles(const std::vector<Group>& groups);

constexpr Eigen::Index most_latest_cycles = 5;  ///< of which summaries have mean and spread

/// Sums over the cycle that is being measured, and the last two measured; everything needed to continue bit for bit.
struct CycleSums {
  std::int64_t number = -1;                              ///< of the cycle being measured; −1: none
  std::int64_t samples = 0;                              ///< steps of it so far
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();  ///< from the case's placement to its start
  Eigen::Matrix3Xd first_position_m;                     ///< of the bodies at its start
  Eigen::VectorXd first_arm_m;
  Eigen::VectorXd arm_m;         ///< Σ (l − l at start); small numbers sum up with less rounding
  Eigen::VectorXd arm_cosine_m;  ///< Σ (l − l at start) cos ωt
  Eigen::VectorXd arm_sine_m;
  double power_W = 0.0;        ///< Σ F_dri · v
  double dissipation_W = 0.0;  ///< −Σ (F · v + T · ω), loads of the fluid
  std::optional<double> power_as_in_paper_W;
  Eigen::VectorXd max_speed_m_per_s;
  Eigen::VectorXd max_speed_along_m_per_s;
  Cycle last, before_last;
  Eigen::VectorXd latest_along_m;  ///< way along the own axis in up to most_latest_cycles, without the very first
};

/// Measures every swimmer over each full cycle of its drive, from every step, storing none
/// [docs/theory.md, (C7), (C8), (C13)–(C15)].
class CycleObserver final : public Observer {
 public:
  explicit CycleObserver(std::vector<Group> groups) : groups_(std::move(groups)), sums_(groups_.size()) {}

  /// @param table  receives every cycle that ends, and must outlive this object; null: none does
  void write_to(CycleTable* table) { table_ = table; }

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  /// Whether the motion of every swimmer in its last full cycle is that of the one before, up to `tolerance` of it.
  [[nodiscard]] bool is_periodic(double tolerance) const;
  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }
  [[nodiscard]] const std::vector<CycleSums>& sums() const { return sums_; }
  /// Of all bodies when the run ends, shape (3, bodies).
  [[nodiscard]] const Eigen::Matrix3Xd& end_position_m() const { return end_position_m_; }
  /// @param step        that comes next
  /// @param first_step  of the run; a cycle that began before it is not measured
  /// @throws StorageError if the sums are not of these swimmers before that step
  void restore(const std::vector<CycleSums>& sums, std::int64_t step, std::int64_t first_step);

 private:
  void open(const Group& group, CycleSums& sums, const StepRecord& record);
  void sample(const Group& group, CycleSums& sums, const StepRecord& record);
  void close(const Group& group, CycleSums& sums, const StepRecord& record);
  void set_phase(std::int64_t within, std::int64_t period_steps);

  std::vector<Group> groups_;
  std::vector<CycleSums> sums_;
  Eigen::Matrix3Xd end_position_m_;
  CycleTable* table_ = nullptr;
  std::int64_t phase_within_ = -1, phase_period_ = 0;  ///< of which cosine and sine are; most swimmers share them
  double cosine_ = 1.0, sine_ = 0.0;
};

}  // namespace copepod::coupler
