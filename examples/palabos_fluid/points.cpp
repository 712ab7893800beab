#include "points.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

constexpr double pi = std::numbers::pi;

/// Adds one ring whose points, a multiple of four, are about a cell apart.
void add_ring(std::vector<Point>& points, double radius_lu, double z_lu, double volume_lu) {
  const int count = 4 * std::max(1, static_cast<int>(std::lround(2 * pi * radius_lu / 4)));
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * pi * (k + 0.5) / count;
    points.push_back({{radius_lu * std::cos(angle), radius_lu * std::sin(angle), z_lu}, volume_lu / count});
  }
}

/// Adds the shell between two radii, with its points at `radius_lu`.
void add_shell(std::vector<Point>& points, double inner_lu, double outer_lu, double radius_lu, double half_length_lu) {
  const double spherical_lu = 4.0 / 3.0 * pi * (std::pow(outer_lu, 3) - std::pow(inner_lu, 3));
  const double cylindrical_lu = 2 * pi * half_length_lu * (outer_lu * outer_lu - inner_lu * inner_lu);
  const int bands = 2 * std::max(1, static_cast<int>(std::lround(pi * radius_lu / 2)));
  for (int k = 0; k < bands; ++k) {
    const double from = pi * k / bands;
    const double to = pi * (k + 1) / bands;
    const double z_lu = radius_lu * std::cos(0.5 * (from + to));
    add_ring(points, radius_lu * std::sin(0.5 * (from + to)), z_lu + std::copysign(half_length_lu, z_lu),
             spherical_lu * 0.5 * (std::cos(from) - std::cos(to)));
  }
  const int rings = static_cast<int>(std::ceil(2 * half_length_lu));
  for (int k = 0; k < rings; ++k)
    add_ring(points, radius_lu, half_length_lu * ((2 * k + 1.0) / rings - 1), cylindrical_lu / rings);
}

}  // namespace

std::vector<Point> fill_body(double radius_lu, double half_length_lu, double retraction_lu) {
  std::vector<Point> points;
  double retraction = retraction_lu;
  for (double outer_lu = radius_lu; outer_lu > 0; outer_lu -= 1) {
    const double inner_lu = outer_lu < 1.5 ? 0.0 : outer_lu - 1;
    add_shell(points, inner_lu, outer_lu, std::max(outer_lu - retraction, 0.5 * outer_lu), half_length_lu);
    if (inner_lu == 0.0) break;
    retraction = 0.5;
  }
  return points;
}
