#pragma once

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
  /// @param contact  for the error
  OverlapCheck(const BodyModel& model, NearPairs& near_pairs, const ContactSpecification& contact = {});

  /// @param state  finite
  /// @param step   for the error
  /// @throws SolverError naming two bodies that overlap, by how much, and what to do
  void check(const MotionState& state, std::int64_t step, ThreadTeam& team);

 private:
  [[nodiscard]] CoreSegment core(Eigen::Index body, const MotionState& state) const;
  void check_pair(int A, int B, const MotionState& state, std::int64_t step) const;
  [[noreturn]] void report(int A, int B, double gap_m, std::int64_t step) const;

  const BodyModel& model_;
  NearPairs& near_pairs_;
  bool contacts_are_resolved_;
};

}  // namespace copepod::body
