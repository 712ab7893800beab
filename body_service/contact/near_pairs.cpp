#include "contact/near_pairs.hpp"

#include <algorithm>

namespace copepod::body {

namespace {

/// Share of its radius by which a body may move before the pairs are listed anew.
constexpr double margin_per_radius = 0.25;

std::vector<double> margins_m(const BodyModel& model) {
  std::vector<double> margins;
  for (Eigen::Index body = 0; body < model.bodies(); ++body) {
    margins.push_back(margin_per_radius * model.shape(body).radius_m);
  }
  return margins;
}

/// Radii of balls that intersect whenever the bodies could touch after each has moved by its margin.
std::vector<double> reaches_m(const BodyModel& model, const std::vector<double>& margin_m) {
  std::vector<double> reaches;
  for (Eigen::Index body = 0; body < model.bodies(); ++body) {
    reaches.push_back(bounding_radius_m(model.shape(body)) + margin_m[body]);
  }
  return reaches;
}

}  // namespace

NearPairs::NearPairs(const BodyModel& model, const std::array<double, 3>& periodic_length_m)
    : margin_m_(margins_m(model)), grid_(reaches_m(model, margin_m_), periodic_length_m) {
  for (Eigen::Index body = 0; body < model.bodies(); ++body) {
    const double extent_m = 2.0 * bounding_radius_m(model.shape(body));
    const bool longer = std::any_of(periodic_length_m.begin(), periodic_length_m.end(),
                                    [&](double length_m) { return length_m > 0.0 && extent_m > length_m; });
    if (longer) longer_than_the_box_.push_back(static_cast<int>(body));
  }
}

const std::vector<BodyPair>& NearPairs::at(const Eigen::Matrix3Xd& position_m) {
  if (moved_beyond_margin(position_m)) {
    listed_position_m_ = position_m;
    grid_.find_pairs(position_m, pairs_);
    std::sort(pairs_.begin(), pairs_.end());
  }
  return pairs_;
}

/// Turning does not matter: it maps the bounding balls, by which pairs are listed, to themselves.
bool NearPairs::moved_beyond_margin(const Eigen::Matrix3Xd& position_m) const {
  if (listed_position_m_.cols() != position_m.cols()) return true;
  for (Eigen::Index body = 0; body < position_m.cols(); ++body) {
    const double shift_m2 = (position_m.col(body) - listed_position_m_.col(body)).squaredNorm();
    if (shift_m2 > margin_m_[body] * margin_m_[body]) return true;
  }
  return false;
}

}  // namespace copepod::body
