#pragma once

#include <cstdint>

#include "geometry/near_pairs.hpp"
#include "geometry/shapes/overlaps.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"
#include "threads/thread_team.hpp"

namespace copepod::body {

/// Finds bodies that overlap.
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
  void check_pair(int A, int B, const MotionState& state, std::int64_t step) const;

  const BodyModel& model_;
  NearPairs& near_pairs_;
  Overlaps overlaps_;
  bool contacts_are_resolved_;
};

}  // namespace copepod::body
