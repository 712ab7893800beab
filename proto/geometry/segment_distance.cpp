#include "geometry/segment_distance.hpp"

namespace copepod {

double nearest_place(const CoreSegment& first, const CoreSegment& second) {
  const Eigen::Vector3d& h1 = first.half_W_m;
  const Eigen::Vector3d& h2 = second.half_W_m;
  const Eigen::Vector3d d = second.centre_W_m - first.centre_W_m;

  // Nearest points of the two infinite lines; parallel lines have many, any of which serves as a start.
  const double a = h1.squaredNorm();
  const double b = h1.dot(h2);
  const double e = h2.squaredNorm();
  const double determinant = a * e - b * b;
  double s = 0.0;
  if (determinant > 1e-14 * a * e) s = std::clamp((e * h1.dot(d) - b * h2.dot(d)) / determinant, -1.0, 1.0);

  // The end of one segment may be nearest to an inner point of the other: project there and back.
  const double t = nearest_place(second, first.centre_W_m + s * h1);
  return nearest_place(first, second.centre_W_m + t * h2);
}

double segment_distance_m(const CoreSegment& first, const CoreSegment& second) {
  const Eigen::Vector3d point = first.centre_W_m + nearest_place(first, second) * first.half_W_m;
  return (point - second.centre_W_m - nearest_place(second, point) * second.half_W_m).norm();
}

}  // namespace copepod
