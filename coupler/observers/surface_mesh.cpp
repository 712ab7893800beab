#include "observers/surface_mesh.hpp"

#include <cmath>
#include <numbers>

namespace copepod::coupler {

namespace {

/// A ring of a half sphere whose centre lies at `center_m` on the z axis; a pole is a ring of one point.
struct Ring {
  double polar_rad = 0.0;
  double center_m = 0.0;
  int points = 1;
};

/// From the upper pole to the lower one; the equator of a sphere once, the two ends of a cylinder both.
std::vector<Ring> rings_of(const Shape& shape, int around) {
  const int bands = around / 4;  // of a half sphere
  const double half_m = core_half_length_m(shape);
  std::vector<Ring> rings;
  for (const double center_m : {half_m, -half_m})
    for (int band = 0; band <= bands; ++band) {
      const bool upper = rings.size() <= static_cast<std::size_t>(bands);
      if (!upper && band == 0 && half_m == 0.0) continue;
      const int from_pole = upper ? band : band + bands;
      const bool is_pole = from_pole == 0 || from_pole == 2 * bands;
      rings.push_back({std::numbers::pi * from_pole / (2 * bands), center_m, is_pole ? 1 : around});
    }
  return rings;
}

}  // namespace

SurfaceMesh surface_mesh(const Shape& shape, int around) {
  const std::vector<Ring> rings = rings_of(shape, around);
  SurfaceMesh mesh;
  int points = 0;
  for (const Ring& ring : rings) points += ring.points;
  mesh.points_m.resize(3, points);
  mesh.normals.resize(3, points);
  int upper = 0;  // first point of the ring above
  int first = 0;  // of this ring
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Ring& ring = rings[i];
    for (int j = 0; j < ring.points; ++j) {
      const double azimuth_rad = 2.0 * std::numbers::pi * j / around;
      const Eigen::Vector3d normal{std::sin(ring.polar_rad) * std::cos(azimuth_rad),
                                   std::sin(ring.polar_rad) * std::sin(azimuth_rad), std::cos(ring.polar_rad)};
      mesh.normals.col(first + j) = normal;
      mesh.points_m.col(first + j) = shape.radius_m * normal + ring.center_m * Eigen::Vector3d::UnitZ();
    }
    if (i > 0) {
      if (!mesh.strip.empty()) mesh.strip.insert(mesh.strip.end(), {mesh.strip.back(), upper});
      for (int j = 0; j <= around; ++j)
        mesh.strip.insert(mesh.strip.end(), {upper + j % rings[i - 1].points, first + j % ring.points});
    }
    upper = first;
    first += ring.points;
  }
  return mesh;
}

}  // namespace copepod::coupler
