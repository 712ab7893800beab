#include "contact/overlap_check.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <string>

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

std::string in_metres(double length_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3e m", length_m);
  return text.data();
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
  if (depth_m > 0.0) report(A, B, depth_m, step);
}

void OverlapCheck::report(int A, int B, double depth_m, std::int64_t step) const {
  const std::string depth = in_metres(depth_m);
  if (A == B) {
    throw SolverError("body '" + model_.name(A) + "' overlaps with its own periodic image by " + depth +
                          " (the periodic length is shorter than the body). Use a larger domain.",
                      0, step);
  }
  if (contacts_are_resolved_) {
    throw SolverError("bodies '" + model_.name(A) + "' and '" + model_.name(B) + "' overlap by " + depth +
                          " at the start (a contact would push them apart at once). Start them further apart.",
                      0, step);
  }
  throw SolverError(
      "bodies '" + model_.name(A) + "' and '" + model_.name(B) + "' overlap by " + depth +
          " (contacts are not resolved). Let bodies rebound (contact: {} in the case), start them further apart, or "
          "use a smaller amplitude of the drive (amplitude_N, amplitude_m), a stiffer spring or a shorter step.",
      0, step);
}

}  // namespace copepod::body
