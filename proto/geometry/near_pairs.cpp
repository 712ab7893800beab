#include "geometry/near_pairs.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace copepod {

namespace {

/// Share of its radius by which a body may move before the pairs are listed anew.
constexpr double margin_per_radius = 0.25;

double margin_m(const Shape& shape) { return margin_per_radius * shape.radius_m; }

std::vector<double> of_each(const std::vector<Shape>& shapes, const auto& length_m) {
  std::vector<double> lengths_m;
  lengths_m.reserve(shapes.size());
  for (const Shape& shape : shapes) lengths_m.push_back(length_m(shape));
  return lengths_m;
}

/// Sorts pairs of neighbours in time linear in their number: by the lower body by counting, then the few of each body.
/// @param sorted  overwritten
void sort_pairs(const std::vector<BodyPair>& pairs, std::size_t bodies, std::vector<BodyPair>& sorted) {
  std::vector<std::ptrdiff_t> end(bodies + 1);  // of the pairs of each body; while they are filled in, the next place
  for (const BodyPair& pair : pairs) ++end[pair.first + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  sorted.resize(pairs.size());
  for (const BodyPair& pair : pairs) sorted[end[pair.first]++] = pair;
  auto from = sorted.begin();
  for (std::size_t body = 0; body < bodies; ++body) {
    const auto to = sorted.begin() + end[body];
    std::sort(from, to);
    from = to;
  }
}

}  // namespace

std::vector<BodyPair> jointed_pairs(const std::vector<JointSpecification>& joints) {
  std::vector<BodyPair> pairs;
  for (const JointSpecification& joint : joints)
    if (joint.body_B >= 0)
      pairs.emplace_back(std::min(joint.body_A, joint.body_B), std::max(joint.body_A, joint.body_B));
  std::ranges::sort(pairs);
  return pairs;
}

NearPairs::NearPairs(const std::vector<Shape>& shapes, double reach_m, const std::array<double, 3>& periodic_length_m,
                     std::vector<BodyPair> except)
    : margin_m_(of_each(shapes, margin_m)),
      // Balls that intersect whenever the bodies could be near after each has moved by its margin.
      grid_(of_each(shapes, [&](const Shape& s) { return bounding_radius_m(s) + 0.5 * reach_m + margin_m(s); }),
            periodic_length_m),
      except_(std::move(except)) {
  for (std::size_t body = 0; body < shapes.size(); ++body) {
    const double extent_m = 2.0 * bounding_radius_m(shapes[body]);
    if (std::ranges::any_of(periodic_length_m, [&](double length_m) { return length_m > 0.0 && extent_m > length_m; }))
      longer_than_the_box_.push_back(static_cast<int>(body));
  }
}

void NearPairs::list(const Eigen::Matrix3Xd& position_m) {
  listed_position_m_ = position_m;
  grid_.find_pairs(position_m, found_);
  sort_pairs(found_, margin_m_.size(), pairs_);
  if (!except_.empty())
    std::erase_if(pairs_, [this](const BodyPair& pair) { return std::ranges::binary_search(except_, pair); });
  ++listing_;
}

/// Turning does not matter: it maps the bounding balls, by which pairs are listed, to themselves.
bool NearPairs::hold(const Eigen::Matrix3Xd& position_m, std::size_t first, std::size_t last) const {
  if (listed_position_m_.cols() != position_m.cols()) return false;
  for (std::size_t body = first; body < last; ++body) {
    const double shift_m2 = (position_m.col(body) - listed_position_m_.col(body)).squaredNorm();
    if (shift_m2 > margin_m_[body] * margin_m_[body]) return false;
  }
  return true;
}

}  // namespace copepod
