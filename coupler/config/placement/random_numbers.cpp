#include "config/placement/random_numbers.hpp"

#include <cmath>

namespace copepod::coupler {

Eigen::Vector4d RandomNumbers::orientation() {
  const Eigen::Vector2d first = point_of_disk();
  const Eigen::Vector2d second = point_of_disk();
  const double scale = std::sqrt((1.0 - first.dot(first)) / second.dot(second));
  return {first[0], first[1], second[0] * scale, second[1] * scale};
}

Eigen::Vector3d RandomNumbers::direction_about_z(double least) {
  const double z = 1.0 - (1.0 - least) * fraction();
  const Eigen::Vector2d point = point_of_disk();
  const double scale = std::sqrt(std::fmax(0.0, 1.0 - z * z) / point.dot(point));
  return {point[0] * scale, point[1] * scale, z};
}

Eigen::Vector2d RandomNumbers::point_of_disk() {
  for (;;) {
    const double x = 2.0 * fraction() - 1.0;
    const double y = 2.0 * fraction() - 1.0;
    const double square = x * x + y * y;
    if (square > 0.0 && square <= 1.0) return {x, y};
  }
}

}  // namespace copepod::coupler
