#include "geometry/neighbour_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

namespace copepod {

namespace {

/// Cells along one axis. Further out, a double cannot distinguish neighbours and an integer would overflow.
constexpr double furthest = 1e15;

std::size_t bucket(const std::array<std::int64_t, 3>& cell, std::size_t buckets) {
  // Teschner et al. (2003): products with large primes spread neighbouring cells over the table.
  const auto x = static_cast<std::uint64_t>(cell[0]) * 73856093ULL;
  const auto y = static_cast<std::uint64_t>(cell[1]) * 19349663ULL;
  const auto z = static_cast<std::uint64_t>(cell[2]) * 83492791ULL;
  return (x ^ y ^ z) & (buckets - 1);
}

/// Steps to the neighbouring cells of one direction; fewer where that is periodic and has less than 3 cells.
std::pair<std::int64_t, std::int64_t> neighbour_steps(std::int64_t cells) {
  if (cells == 1) return {0, 0};
  if (cells == 2) return {0, 1};
  return {-1, 1};
}

std::int64_t wrapped(std::int64_t index, std::int64_t cells) {
  if (cells == 0) return index;
  const std::int64_t rest = index % cells;
  return rest < 0 ? rest + cells : rest;
}

}  // namespace

NeighbourGrid::NeighbourGrid(std::vector<double> radius_m, const std::array<double, 3>& periodic_length_m)
    : radius_m_(std::move(radius_m)),
      images_{periodic_length_m},
      cell_of_ball_(radius_m_.size()),
      bucket_of_ball_(radius_m_.size()) {
  std::map<int, std::vector<int>> balls_of_size;
  for (std::size_t ball = 0; ball < radius_m_.size(); ++ball)
    balls_of_size[std::ilogb(radius_m_[ball])].push_back(static_cast<int>(ball));
  for (auto& [exponent, balls] : balls_of_size) {
    double largest_m = 0.0;
    for (const int ball : balls) largest_m = std::max(largest_m, radius_m_[ball]);
    add_level(std::move(balls), largest_m);
  }
}

void NeighbourGrid::add_level(std::vector<int> balls, double largest_radius_m) {
  Level level;
  level.cell_width_m.setConstant(2.0 * largest_radius_m);
  for (int direction = 0; direction < 3; ++direction) {
    level.cells[direction] = 0;
    const double length_m = images_.length_m[direction];
    if (length_m <= 0.0) continue;
    level.cells[direction] = std::max<std::int64_t>(
        1, static_cast<std::int64_t>(std::min(length_m / level.cell_width_m[direction], furthest)));
    level.cell_width_m[direction] = length_m / static_cast<double>(level.cells[direction]);
  }
  level.bucket_start.resize(std::bit_ceil(2 * balls.size()) + 1);
  level.entries.resize(balls.size());
  level.balls = std::move(balls);
  levels_.push_back(std::move(level));
}

NeighbourGrid::Cell NeighbourGrid::cell_of(const Level& level, const Eigen::Vector3d& point_m) const {
  Cell cell;
  for (int direction = 0; direction < 3; ++direction) {
    const double index = std::floor(point_m[direction] / level.cell_width_m[direction]);
    cell[direction] =
        wrapped(static_cast<std::int64_t>(std::clamp(index, -furthest, furthest)), level.cells[direction]);
  }
  return cell;
}

void NeighbourGrid::sort_into_cells(Level& level, const Eigen::Matrix3Xd& centre_m) {
  auto& start = level.bucket_start;
  const std::size_t buckets = start.size() - 1;
  std::fill(start.begin(), start.end(), 0U);
  for (const int ball : level.balls) {
    cell_of_ball_[ball] = cell_of(level, centre_m.col(ball));
    bucket_of_ball_[ball] = static_cast<std::uint32_t>(bucket(cell_of_ball_[ball], buckets));
    ++start[bucket_of_ball_[ball] + 1];
  }
  for (std::size_t b = 0; b < buckets; ++b) start[b + 1] += start[b];
  // Filling from the back leaves start[b] at the start of the bucket and keeps its balls in ascending order.
  for (auto ball = level.balls.rbegin(); ball != level.balls.rend(); ++ball)
    level.entries[--start[bucket_of_ball_[*ball] + 1]] = {cell_of_ball_[*ball], *ball};
  for (std::size_t b = 0; b < buckets; ++b) start[b] = start[b + 1];
  start[buckets] = static_cast<std::uint32_t>(level.entries.size());
}

void NeighbourGrid::find_pairs(const Eigen::Matrix3Xd& centre_m, std::vector<BodyPair>& pairs) {
  pairs.clear();
  for (auto& level : levels_) sort_into_cells(level, centre_m);
  for (std::size_t own = 0; own < levels_.size(); ++own)
    for (const int ball : levels_[own].balls)
      for (std::size_t other = own; other < levels_.size(); ++other)
        add_partners(ball, levels_[other], other == own, centre_m, pairs);
}

void NeighbourGrid::add_partners(int ball, const Level& level, bool own_level, const Eigen::Matrix3Xd& centre_m,
                                 std::vector<BodyPair>& pairs) const {
  const std::size_t buckets = level.bucket_start.size() - 1;
  const Cell home = cell_of(level, centre_m.col(ball));
  const auto [x_first, x_last] = neighbour_steps(level.cells[0]);
  const auto [y_first, y_last] = neighbour_steps(level.cells[1]);
  const auto [z_first, z_last] = neighbour_steps(level.cells[2]);
  for (auto x = x_first; x <= x_last; ++x)
    for (auto y = y_first; y <= y_last; ++y)
      for (auto z = z_first; z <= z_last; ++z) {
        const Cell cell{wrapped(home[0] + x, level.cells[0]), wrapped(home[1] + y, level.cells[1]),
                        wrapped(home[2] + z, level.cells[2])};
        const std::size_t b = bucket(cell, buckets);
        for (auto e = level.bucket_start[b]; e < level.bucket_start[b + 1]; ++e) {
          const auto& [entry_cell, other] = level.entries[e];
          if (entry_cell != cell || (own_level && other <= ball)) continue;
          const double reach_m = radius_m_[ball] + radius_m_[other];
          const Eigen::Vector3d difference_m = centre_m.col(other) - centre_m.col(ball);
          if (images_.nearest_m(difference_m).squaredNorm() < reach_m * reach_m)
            pairs.emplace_back(std::min(ball, other), std::max(ball, other));
        }
      }
}

}  // namespace copepod
