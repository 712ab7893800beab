#include "contact/overlap_check.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>

#include "contract/errors.hpp"

namespace copepod::body {

namespace {

/// Calls work(first, last) for ranges that cover [0, count).
template <class Work>
void share_ranges(ThreadTeam& team, std::size_t count, const Work& work) {
  constexpr std::size_t part = 16384;
  team.share(static_cast<std::int64_t>((count + part - 1) / part), [&](std::int64_t index, int) {
    const std::size_t first = part * static_cast<std::size_t>(index);
    work(first, std::min(first + part, count));
  });
}

}  // namespace

OverlapCheck::OverlapCheck(const BodyModel& model, NearPairs& near_pairs, const ContactSpecification& contact)
    : model_(model),
      near_pairs_(near_pairs),
      overlaps_(model.shapes(), near_pairs.images()),
      contacts_are_resolved_(contact.stiffness_N_per_m > 0.0) {}

void OverlapCheck::check(const MotionState& state, std::int64_t step, ThreadTeam& team) {
  std::atomic<bool> hold = true;
  share_ranges(team, static_cast<std::size_t>(state.bodies()), [&](std::size_t first, std::size_t last) {
    if (!near_pairs_.hold(state.position_m, first, last)) hold = false;
  });
  if (!hold) near_pairs_.list(state.position_m);
  const std::vector<BodyPair>& pairs = near_pairs_.listed();
  share_ranges(team, pairs.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) check_pair(pairs[i].first, pairs[i].second, state, step);
  });
  for (const int body : near_pairs_.longer_than_the_box()) check_pair(body, body, state, step);
}

void OverlapCheck::check_pair(int A, int B, const MotionState& state, std::int64_t step) const {
  const double depth_m = overlaps_.depth_m(A, B, state.position_m, state.orientation_wxyz);
  if (!(depth_m > 0.0)) return;
  std::array<char, 32> depth{};
  std::snprintf(depth.data(), depth.size(), " by %.3e m", depth_m);
  if (A == B)
    throw SolverError("body '" + model_.name(A) + "' overlaps with its own periodic image" + depth.data() +
                          " (the periodic length is shorter than the body). Use a larger domain.",
                      0, step);
  throw SolverError(
      "bodies '" + model_.name(A) + "' and '" + model_.name(B) + "' overlap" + depth.data() +
          (contacts_are_resolved_
               ? " at the start (a contact would push them apart at once). Start them further apart."
               : " (contacts are not resolved). Let bodies rebound (contact: {} in the case), start them further "
                 "apart, or use a smaller amplitude of the drive (amplitude_N, amplitude_m), a stiffer spring or a "
                 "shorter step."),
      0, step);
}

}  // namespace copepod::body
