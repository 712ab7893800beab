#include "contact/overlap_check.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>

#include "contract/errors.hpp"
#include "model/mass_properties.hpp"
#include "model/rotation.hpp"

namespace copepod::body {

namespace {

/// Share of its radius by which a body may move before the candidates are listed anew.
constexpr double margin_per_radius = 0.25;

std::vector<double> margins_m(const BodyModel& model) {
  std::vector<double> margins;
  for (Eigen::Index body = 0; body < model.bodies(); ++body) {
    margins.push_back(margin_per_radius * model.shape(body).radius_m);
  }
  return margins;
}

std::vector<double> bounding_radii_m(const BodyModel& model) {
  std::vector<double> radii;
  for (Eigen::Index body = 0; body < model.bodies(); ++body)
    radii.push_back(bounding_radius_m(model.shape(body)));
  return radii;
}

std::vector<double> sums(std::vector<double> first, const std::vector<double>& second) {
  for (std::size_t i = 0; i < first.size(); ++i) first[i] += second[i];
  return first;
}

std::string in_metres(double length_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3e m", length_m);
  return text.data();
}

}  // namespace

OverlapCheck::OverlapCheck(const BodyModel& model, const std::array<double, 3>& periodic_length_m)
    : model_(model),
      periodic_length_m_(periodic_length_m),
      margin_m_(margins_m(model)),
      bounding_radius_m_(bounding_radii_m(model)),
      grid_(sums(bounding_radius_m_, margin_m_), periodic_length_m) {
  for (Eigen::Index body = 0; body < model.bodies(); ++body) {
    const double extent_m = 2.0 * bounding_radius_m_[body];
    const bool longer = std::any_of(periodic_length_m.begin(), periodic_length_m.end(),
                                    [&](double length_m) { return length_m > 0.0 && extent_m > length_m; });
    if (longer) longer_than_the_box_.push_back(static_cast<int>(body));
  }
}

CoreSegment OverlapCheck::core(Eigen::Index body, const MotionState& state) const {
  const double half_length_m = core_half_length_m(model_.shape(body));
  if (half_length_m == 0.0) return {state.position_m.col(body), Eigen::Vector3d::Zero()};
  return {state.position_m.col(body), half_length_m * z_axis(state.orientation_wxyz.col(body))};
}

void OverlapCheck::check(const MotionState& state, std::int64_t step) {
  if (moved_beyond_margin(state)) list_candidates(state);
  for (const auto& [A, B] : candidates_) check_pair(A, B, state, step);
  for (const int body : longer_than_the_box_) check_pair(body, body, state, step);
}

bool OverlapCheck::moved_beyond_margin(const MotionState& state) const {
  if (listed_centre_m_.cols() != state.bodies()) return true;
  // Turning does not matter: the bounding balls, by which candidates are listed, turn into themselves.
  for (Eigen::Index body = 0; body < state.bodies(); ++body) {
    const double shift_m2 = (state.position_m.col(body) - listed_centre_m_.col(body)).squaredNorm();
    if (shift_m2 > margin_m_[body] * margin_m_[body]) return true;
  }
  return false;
}

void OverlapCheck::list_candidates(const MotionState& state) {
  listed_centre_m_ = state.position_m;
  grid_.find_pairs(state.position_m, candidates_);
  // Ascending order: bodies that are neighbours in the setup are neighbours in memory.
  std::sort(candidates_.begin(), candidates_.end());
}

void OverlapCheck::check_pair(int A, int B, const MotionState& state, std::int64_t step) const {
  const double gap_m = smallest_gap_m(A, B, state);
  if (gap_m < 0.0) report(A, B, gap_m, step);
}

double OverlapCheck::smallest_gap_m(int A, int B, const MotionState& state) const {
  const CoreSegment first{Eigen::Vector3d::Zero(), core(A, state).half_W_m};
  CoreSegment second = core(B, state);
  const Eigen::Vector3d nearest_m = grid_.nearest_image_m(state.position_m.col(B) - state.position_m.col(A));

  // The image with the nearest centre need not be the nearest image of bodies that are longer than half the
  // box.
  const double reach_m = bounding_radius_m_[A] + bounding_radius_m_[B];
  std::array<int, 3> images{};
  for (int direction = 0; direction < 3; ++direction) {
    const double length_m = periodic_length_m_[direction];
    if (length_m > 0.0 && 2.0 * reach_m > length_m)
      images[direction] = 1 + static_cast<int>(reach_m / length_m);
  }
  double smallest_m = std::numeric_limits<double>::infinity();
  for (int x = -images[0]; x <= images[0]; ++x) {
    for (int y = -images[1]; y <= images[1]; ++y) {
      for (int z = -images[2]; z <= images[2]; ++z) {
        if (A == B && x == 0 && y == 0 && z == 0) continue;
        second.centre_W_m = nearest_m + Eigen::Vector3d(x * periodic_length_m_[0], y * periodic_length_m_[1],
                                                        z * periodic_length_m_[2]);
        smallest_m = std::min(smallest_m, segment_distance_m(first, second));
      }
    }
  }
  return smallest_m - model_.shape(A).radius_m - model_.shape(B).radius_m;
}

void OverlapCheck::report(int A, int B, double gap_m, std::int64_t step) const {
  const std::string depth = in_metres(-gap_m);
  if (A == B) {
    throw SolverError("body '" + model_.name(A) + "' overlaps with its own periodic image by " + depth +
                          " (the periodic length is shorter than the body). Use a larger domain.",
                      0, step);
  }
  throw SolverError(
      "bodies '" + model_.name(A) + "' and '" + model_.name(B) + "' overlap by " + depth +
          " (they came too close; contacts are not resolved). Start them further apart, use a smaller "
          "driving force, a stiffer spring or a shorter step.",
      0, step);
}

}  // namespace copepod::body
