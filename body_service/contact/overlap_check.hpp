#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "contact/neighbour_grid.hpp"
#include "contact/segment_distance.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// Finds bodies that overlap: spheres and capsules in any combination, periodic images included.
///
///   gap = distance of the core segments − r_A − r_B,   overlap if gap < 0                   (B13)
///
/// Pairs that could touch are looked up in a grid only when some body has moved by more than a margin since
/// the last time; in between the few pairs on the list are measured. Two bodies that are not on the list are
/// further apart than the sum of their margins.
class OverlapCheck {
 public:
  /// @param periodic_length_m  0: that direction is not periodic
  OverlapCheck(const BodyModel& model, const std::array<double, 3>& periodic_length_m);

  /// @param state  finite
  /// @param step   for the error
  /// @throws SolverError naming two bodies that overlap, by how much, and what to do
  void check(const MotionState& state, std::int64_t step);

 private:
  [[nodiscard]] CoreSegment core(Eigen::Index body, const MotionState& state) const;
  [[nodiscard]] bool moved_beyond_margin(const MotionState& state) const;
  void list_candidates(const MotionState& state);
  void check_pair(int A, int B, const MotionState& state, std::int64_t step) const;
  [[nodiscard]] double smallest_gap_m(int A, int B, const MotionState& state) const;
  [[noreturn]] void report(int A, int B, double gap_m, std::int64_t step) const;

  const BodyModel& model_;
  std::array<double, 3> periodic_length_m_;
  std::vector<double> margin_m_;
  std::vector<double> bounding_radius_m_;
  NeighbourGrid grid_;
  std::vector<BodyPair> candidates_;
  std::vector<int> longer_than_the_box_;  ///< bodies that may overlap with their own periodic image
  Eigen::Matrix3Xd listed_centre_m_;      ///< when the candidates were listed; no columns: never
};

}  // namespace copepod::body
