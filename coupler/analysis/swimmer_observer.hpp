#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "analysis/swimmer_figures.hpp"
#include "config/sections/case.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

/// Sums over the last full driven period, steps [start, stop); everything needed to continue bit for bit.
struct PeriodSums {
  double first_position_m = 0.0;         ///< of the middle bead along the axis at `start`
  double last_position_m = 0.0;          ///< at `stop`
  std::array<double, 2> arm_m{};         ///< Σ (l − l at start)
  std::array<double, 2> arm_cosine_m{};  ///< Σ (l − l at start) cos ωt
  std::array<double, 2> arm_sine_m{};
  std::array<double, 2> first_arm_m{};
  double power_W = 0.0;  ///< Σ F_dri · u
  double power_rounded_omega_W = 0.0;
  std::array<double, 3> max_speed_m_per_s{};
  std::int64_t samples = 0;
  bool complete = false;  ///< `stop` was seen
};

/// Measures one swimmer over its last full driven period, (cycles − 1) T to cycles T, from every step,
/// storing none.
class SwimmerObserver final : public Observer {
 public:
  /// @param first_body  column of the trailing bead; middle and leading follow
  SwimmerObserver(const Swimmer& swimmer, int first_body);

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  /// Absent if the run did not cover the period.
  [[nodiscard]] std::optional<SwimmerMeasurement> measurement() const;
  [[nodiscard]] std::int64_t start_step() const { return start_step_; }
  [[nodiscard]] std::int64_t stop_step() const { return stop_step_; }

  [[nodiscard]] const PeriodSums& sums() const { return sums_; }
  void restore(const PeriodSums& sums) { sums_ = sums; }

 private:
  void sample(const StepRecord& record);
  void close_period(const StepRecord& record);
  [[nodiscard]] double position_m(const StepRecord& record, int bead) const;

  Swimmer swimmer_;
  Eigen::Vector3d axis_;
  int first_body_;
  std::int64_t start_step_;
  std::int64_t stop_step_;
  PeriodSums sums_;
};

}  // namespace copepod::coupler
