#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "geometry/near_pairs.hpp"
#include "geometry/segment_distance.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"
#include "threads/thread_team.hpp"

namespace copepod::body {

/// Finds bodies that overlap: spheres and capsules in any combination, periodic images included.
///   gap = distance of the core segments − r_A − r_B,   overlap if gap < 0                   (B13)
class OverlapCheck {
 public:
  /// @param model, near_pairs  must outlive this object
  /// @param periodic_length_m  0: that direction is not periodic
  /// @param contact            for the error
  OverlapCheck(const BodyModel& model, const std::array<double, 3>& periodic_length_m, NearPairs& near_pairs,
               const ContactSpecification& contact = {});

  /// @param state  finite
  /// @param step   for the error
  /// @throws SolverError naming two bodies that overlap, by how much, and what to do
  void check(const MotionState& state, std::int64_t step, ThreadTeam& team);

 private:
  [[nodiscard]] CoreSegment core(Eigen::Index body, const MotionState& state) const;
  void check_pair(int A, int B, const MotionState& state, std::int64_t step) const;
  [[nodiscard]] double smallest_gap_m(int A, int B, const MotionState& state) const;
  [[noreturn]] void report(int A, int B, double gap_m, std::int64_t step) const;

  const BodyModel& model_;
  std::array<double, 3> periodic_length_m_;
  NearPairs& near_pairs_;
  bool contacts_are_resolved_;
};

}  // namespace copepod::body
