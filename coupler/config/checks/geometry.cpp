#include "config/checks/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>

namespace copepod::coupler {
namespace {

/// Shortest distance between the segments p ± a/2 and q ± b/2.
/// The closest points minimise |p + s a − q − t b|² over s, t ∈ [−1/2, 1/2]; after one unconstrained solve
/// for s, clamping t and then s again finds the minimum (Ericson, Real-Time Collision Detection, 5.1.9).
double segment_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& q,
                        const Eigen::Vector3d& b) {
  const Eigen::Vector3d r = p - q;
  const double aa = a.squaredNorm();
  const double bb = b.squaredNorm();
  const double ab = a.dot(b);
  const double determinant = aa * bb - ab * ab;
  const auto clamp = [](double x) { return std::clamp(x, -0.5, 0.5); };
  double s = determinant > 1e-12 * aa * bb ? clamp((ab * b.dot(r) - bb * a.dot(r)) / determinant) : 0.0;
  double t = bb > 0.0 ? clamp((b.dot(r) + s * ab) / bb) : 0.0;
  s = aa > 0.0 ? clamp((t * ab - a.dot(r)) / aa) : 0.0;
  t = bb > 0.0 ? clamp((b.dot(r) + s * ab) / bb) : 0.0;
  return (r + s * a - t * b).norm();
}

}  // namespace

Eigen::Vector3d in_world(const BodySpecification& body, const Eigen::Vector3d& vector_B) {
  const Eigen::Vector4d& q = body.orientation_wxyz;
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * vector_B;
}

Eigen::Vector3d body_axis(const BodySpecification& body) {
  const double w = body.orientation_wxyz[0];
  const double x = body.orientation_wxyz[1];
  const double y = body.orientation_wxyz[2];
  const double z = body.orientation_wxyz[3];
  return {2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z};
}

Eigen::Vector3d half_extents_m(const BodySpecification& body) {
  const Eigen::Vector3d axis = body_axis(body);
  return Eigen::Vector3d::Constant(body.shape.radius_m) + 0.5 * body.shape.length_m * axis.cwiseAbs();
}

double surface_distance_m(const BodySpecification& A, const BodySpecification& B,
                          const Eigen::Vector3d& shift_m) {
  const double between_axes = segment_distance(A.position_m, A.shape.length_m * body_axis(A),
                                               B.position_m + shift_m, B.shape.length_m * body_axis(B));
  return between_axes - A.shape.radius_m - B.shape.radius_m;
}

namespace {

/// Cells of a grid that a box touches along one axis: `count` of them from `first` on.
struct CellRange {
  std::int64_t first = 0;
  std::int64_t count = 1;
};

constexpr double farthest = 1e15;  // cells along one axis; beyond them all bodies share one

/// @param low, high  ends of the box
CellRange cells_between(double low, double high, double edge) {
  const auto cell = [edge](double x) {
    return static_cast<std::int64_t>(std::clamp(std::floor(x / edge), -farthest, farthest));
  };
  return {cell(low), cell(high) - cell(low) + 1};
}

std::uint64_t mixed(std::uint64_t hash, std::int64_t cell) {
  hash = (hash ^ static_cast<std::uint64_t>(cell)) * 0x9E3779B97F4A7C15U;
  return hash ^ (hash >> 29U);
}

// Where products of three lengths stay finite.
constexpr double smallest_m = 1e-100;
constexpr double largest_m = 1e100;

/// Edges of the grid's cells: about the size of a box, and larger where a few large bodies would touch too
/// many of them.
Eigen::Vector3d cell_edges(const std::vector<Eigen::Vector3d>& halves,
                           const std::array<double, 3>& periodic_length_m) {
  double sum_m = 0.0;
  for (const Eigen::Vector3d& half : halves) sum_m += 2.0 * half.maxCoeff();
  double edge_m = std::max(sum_m / static_cast<double>(halves.size()), smallest_m);
  const double most_cells = 32.0 * static_cast<double>(halves.size());
  for (double cells = most_cells + 1.0; cells > most_cells; edge_m *= 2.0) {
    cells = 0.0;
    for (const Eigen::Vector3d& half : halves)
      cells += (2.0 * half / edge_m + Eigen::Vector3d::Ones()).prod();
  }
  Eigen::Vector3d edges;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length_m = periodic_length_m[axis];
    edges[static_cast<Eigen::Index>(axis)] =
        length_m > 0.0 ? length_m / std::clamp(std::floor(length_m / edge_m), 1.0, farthest) : edge_m;
  }
  return edges;
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> near_pairs(const std::vector<BodySpecification>& bodies,
                                                            const std::array<double, 3>& periodic_length_m,
                                                            double reach_m) {
  if (bodies.empty()) return {};
  std::vector<Eigen::Vector3d> halves;
  for (const BodySpecification& body : bodies)
    halves.push_back((half_extents_m(body).array() + 0.5 * reach_m).min(largest_m));
  const Eigen::Vector3d edges = cell_edges(halves, periodic_length_m);

  std::vector<std::pair<std::uint64_t, std::size_t>> in_cells;  // cell, body
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    std::array<CellRange, 3> ranges;
    std::array<std::int64_t, 3> periods{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      const double at = bodies[body].position_m[i];
      ranges[axis] = cells_between(at - halves[body][i], at + halves[body][i], edges[i]);
      if (periodic_length_m[axis] <= 0.0) continue;
      periods[axis] = std::llround(periodic_length_m[axis] / edges[i]);
      ranges[axis].count = std::min(ranges[axis].count, periods[axis]);
    }
    const auto key = [&](std::uint64_t hash, std::size_t axis, std::int64_t offset) {
      std::int64_t cell = ranges[axis].first + offset;
      if (periods[axis] > 0) cell = (cell % periods[axis] + periods[axis]) % periods[axis];
      return mixed(hash, cell);
    };
    for (std::int64_t x = 0; x < ranges[0].count; ++x) {
      for (std::int64_t y = 0; y < ranges[1].count; ++y) {
        for (std::int64_t z = 0; z < ranges[2].count; ++z)
          in_cells.emplace_back(key(key(key(0, 0, x), 1, y), 2, z), body);
      }
    }
  }
  std::sort(in_cells.begin(), in_cells.end());

  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < in_cells.size(); ++i) {
    for (std::size_t j = i + 1; j < in_cells.size() && in_cells[j].first == in_cells[i].first; ++j) {
      if (in_cells[i].second < in_cells[j].second) pairs.emplace_back(in_cells[i].second, in_cells[j].second);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace copepod::coupler
