#include "config/placement/placement.hpp"

#include <algorithm>
#include <cmath>

#include "config/placement/geometry.hpp"

namespace copepod::coupler {

namespace {

/// Which of several trials are kept, one after the other.
/// @param is_blocked  by what was there before
/// @param touches     between trials, ascending
std::vector<bool> kept_of(std::vector<bool> is_blocked, const std::vector<Touch>& touches, int first_trial) {
  std::vector<std::vector<int>> rivals(is_blocked.size());  // of each trial, those before it
  for (const Touch& touch : touches) {
    const auto trial = static_cast<std::size_t>(touch.second - first_trial);
    if (touch.first < first_trial)
      is_blocked[trial] = true;
    else
      rivals[trial].push_back(touch.first - first_trial);
  }
  std::vector<bool> is_kept(is_blocked.size());
  for (std::size_t trial = 0; trial < is_kept.size(); ++trial) {
    const auto stays = [&](int rival) { return is_kept[rival]; };
    is_kept[trial] = !is_blocked[trial] && std::ranges::none_of(rivals[trial], stays);
  }
  return is_kept;
}

}  // namespace

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

void Placement::add_copy(const Place& place, std::vector<BodySpecification>& bodies) const {
  const Eigen::Matrix3d R_WS = rotation_matrix(place.orientation_wxyz);
  for (const BodySpecification& own : bodies_) {
    BodySpecification& body = bodies.emplace_back();
    body.shape = own.shape;
    body.position_m = place.center_m + R_WS * own.position_m;
    body.orientation_wxyz = product(place.orientation_wxyz, own.orientation_wxyz);
  }
}

bool Placement::holds(const Place& place) const {
  std::vector<BodySpecification> bodies;
  add_copy(place, bodies);
  return std::ranges::all_of(bodies, [&](const BodySpecification& body) {
    const Eigen::Vector3d half = half_extents_m(body);
    return (body.position_m - half - room_.least_m).minCoeff() >= 0.0 &&
           (room_.most_m - body.position_m - half).minCoeff() >= 0.0;
  });
}

std::vector<Touch> Placement::touches(const std::vector<Place>& places, std::size_t from) const {
  std::vector<BodySpecification> bodies = room_.obstacles;
  for (const Place& place : places) add_copy(place, bodies);
  const auto obstacles = static_cast<int>(room_.obstacles.size());
  const auto of_copy = static_cast<int>(bodies_.size());
  const auto owner = [&](int body) { return body < obstacles ? -1 - body : (body - obstacles) / of_copy; };
  std::vector<Touch> found;
  for (const auto& [a, b] : near_pairs(bodies, room_.periodic_length_m, room_.gap_m)) {
    const int first = owner(a);
    const int second = owner(b);  // the larger one, unless both are obstacles
    if (first == second || second < static_cast<int>(from)) continue;
    const BodySpecification& A = bodies[a];
    const BodySpecification& B = bodies[b];
    const double distance_m = surface_distance_m(A, B, room_.periodic_length_m, room_.gap_m);
    if (distance_m < room_.gap_m) found.push_back({first, second, distance_m});
  }
  return found;
}

std::vector<Place> Placement::fill(std::size_t count, const std::function<Place()>& draw) const {
  constexpr std::size_t least_trials = 256;
  constexpr int most_rounds = 60;
  std::vector<Place> places;
  for (int round = 0; round < most_rounds && places.size() < count; ++round) {
    // Trials do not depend on how many of them are looked at together.
    const std::size_t trials = std::max({count - places.size(), count / 2, least_trials});
    std::vector<Place> all = places;
    std::vector<bool> is_blocked;
    for (std::size_t trial = 0; trial < trials; ++trial) {
      all.push_back(draw());
      is_blocked.push_back(!holds(all.back()));
    }
    const std::vector<bool> is_kept =
        kept_of(std::move(is_blocked), touches(all, places.size()), static_cast<int>(places.size()));
    const std::size_t before = places.size();
    for (std::size_t trial = 0; trial < trials && places.size() < count; ++trial)
      if (is_kept[trial]) places.push_back(all[before + trial]);
  }
  return places;
}

std::vector<Eigen::Vector3d> lattice_of(std::size_t count, const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m,
                                        const Eigen::Vector3d& spacing_m) {
  std::array<std::size_t, 3> cells{1, 1, 1};
  const auto length_m = [&](Eigen::Index axis) {
    return (high_m[axis] - low_m[axis]) / static_cast<double>(cells[axis]);
  };
  while (cells[0] * cells[1] * cells[2] < count) {
    Eigen::Index longest = 0;
    for (Eigen::Index axis = 1; axis < 3; ++axis)
      if (length_m(axis) / spacing_m[axis] > length_m(longest) / spacing_m[longest]) longest = axis;
    ++cells[longest];
  }
  const std::size_t all = cells[0] * cells[1] * cells[2];
  std::vector<Eigen::Vector3d> centres;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t cell = i * all / count;
    const std::array<std::size_t, 3> index{cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]};
    Eigen::Vector3d& centre = centres.emplace_back(low_m);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      centre[axis] += length_m(axis) * (static_cast<double>(index[axis]) + 0.5);
  }
  return centres;
}

}  // namespace copepod::coupler
