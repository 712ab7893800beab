#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Core>

/// A forcing point of a body: where it is, from the centre, and the volume that it stands for. All in cells.
struct Point {
  Eigen::Vector3d place;
  double volume;
};

/// Depth of the outermost points below the surface for which the drag of a sphere is right. The forced layer is as
/// thick as the kernel, and fluid diffuses √ν into it in a step. Fitted to the drag of a periodic array of spheres at
/// 0.02 < ν < 0.5; the same shift holds at radii of 3.7 and 6.2 cells.
inline double depth_of_points(double viscosity_lu) {
  return 1.190 - 1.675 * std::sqrt(viscosity_lu) + 0.416 * viscosity_lu;
}

/// Adds a ring about the z axis whose points, a multiple of four, are about a cell apart.
inline void add_ring(std::vector<Point>& points, double radius, double z, double volume) {
  const int count = 4 * std::max(1, static_cast<int>(std::lround(std::numbers::pi * radius / 2)));
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.5) / count;
    points.push_back({{radius * std::cos(angle), radius * std::sin(angle), z}, volume / count});
  }
}

/// Fills a sphere, or a capsule whose cylinder is 2 half_length long, with shells one cell thick, and these with rings;
/// symmetric about x, y and z.
inline std::vector<Point> fill(double full_radius, double half_length, double depth) {
  constexpr double pi = std::numbers::pi;
  std::vector<Point> points;
  double inner = full_radius;
  for (double outer = full_radius; inner > 0; outer = inner, depth = 0.5) {
    inner = outer < 1.5 ? 0.0 : outer - 1;
    const double radius = std::max(outer - depth, 0.5 * outer);
    const int bands = 2 * std::max(1, static_cast<int>(std::lround(pi * radius / 2)));
    for (int k = 0; k < bands; ++k) {
      const double share = 0.5 * (std::cos(pi * k / bands) - std::cos(pi * (k + 1) / bands));
      const double angle = pi * (k + 0.5) / bands;
      const double z = radius * std::cos(angle);
      add_ring(points, radius * std::sin(angle), z + std::copysign(half_length, z),
               share * 4.0 / 3.0 * pi * (std::pow(outer, 3) - std::pow(inner, 3)));
    }
    const int rings = static_cast<int>(std::ceil(2 * half_length));
    for (int k = 0; k < rings; ++k)
      add_ring(points, radius, half_length * ((2 * k + 1.0) / rings - 1),
               2 * half_length * pi * (outer * outer - inner * inner) / rings);
  }
  return points;
}
