#include "analysis/nearest_distances.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "geometry/neighbour_grid.hpp"

namespace copepod::coupler {

Eigen::VectorXd nearest_distances_m(const Eigen::Matrix3Xd& points_m, const std::array<double, 3>& periodic_length_m) {
  const Eigen::Index points = points_m.cols();
  const double extent_m = (points_m.rowwise().maxCoeff() - points_m.rowwise().minCoeff()).norm();
  constexpr double least_m = 1e-100;  // where all points coincide
  const double first_m = std::max(extent_m / static_cast<double>(points), least_m);
  std::vector<double> radius_m(static_cast<std::size_t>(points), first_m);
  Eigen::VectorXd nearest_m = Eigen::VectorXd::Constant(points, std::numeric_limits<double>::infinity());
  std::vector<BodyPair> pairs;
  for (double largest_m = first_m;; largest_m *= 2.0) {
    NeighbourGrid grid(radius_m, periodic_length_m);
    grid.find_pairs(points_m, pairs);
    for (const auto& [a, b] : pairs) {
      const double distance_m = grid.nearest_image_m(points_m.col(b) - points_m.col(a)).norm();
      nearest_m[a] = std::min(nearest_m[a], distance_m);
      nearest_m[b] = std::min(nearest_m[b], distance_m);
    }
    if (largest_m > extent_m) return nearest_m;  // no point is further away
    bool grows = false;
    for (Eigen::Index i = 0; i < points; ++i) {
      double& radius = radius_m[static_cast<std::size_t>(i)];
      if (nearest_m[i] <= radius) continue;  // all points in its ball are known
      radius *= 2.0;
      grows = true;
    }
    if (!grows) return nearest_m;
  }
}

}  // namespace copepod::coupler
