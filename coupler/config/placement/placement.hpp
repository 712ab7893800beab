#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"

namespace copepod::coupler {

/// Random numbers that a seed determines, the same on every machine: the standard fixes the bits of this generator, but
/// neither those of its distributions nor those of functions such as sin. Only + − × ÷ √ follow it here.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : generator_(seed) {}

  /// Evenly in [0, 1).
  double fraction() { return 0x1p-53 * static_cast<double>(generator_() >> 11U); }

  /// Unit quaternion; every orientation is as likely.
  ///   q = (x₁, x₂, x₃ s, x₄ s),  s = √((1 − x₁² − x₂²) / (x₃² + x₄²))
  /// for two points of the unit disk. Source: Marsaglia, Annals of Mathematical Statistics 43 (1972), 645.
  Eigen::Vector4d orientation();

  /// Unit vector, evenly in the cone about z of the directions whose z component is `least` or more.
  Eigen::Vector3d direction_about_z(double least);

 private:
  /// Evenly in the unit disk without its centre.
  Eigen::Vector2d point_of_disk();

  std::mt19937_64 generator_;
};

/// Where a copy is.
struct Place {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector4d orientation_wxyz{1, 0, 0, 0};
};

/// Where copies may be.
struct Room {
  Eigen::Vector3d least_m;  ///< every surface lies between these; −∞ and ∞ where nothing limits it
  Eigen::Vector3d most_m;
  std::array<double, 3> periodic_length_m{};  ///< 0: not periodic along this axis
  double gap_m = 0.0;                         ///< least distance between surfaces of different copies and obstacles
  std::vector<BodySpecification> obstacles;
};

/// Two copies that are too near each other, or a copy and an obstacle.
struct Touch {
  int first = 0;  ///< number of a place; below 0: of an obstacle, −1 − its number
  int second = 0;
  double distance_m = 0.0;  ///< between their surfaces; negative where they overlap
};

/// Copies of a group of bodies in a room.
class Placement {
 public:
  /// @param bodies  in the frame of the group; their shapes, positions and orientations count
  Placement(std::vector<BodySpecification> bodies, Room room) : bodies_(std::move(bodies)), room_(std::move(room)) {}

  /// Whether every body of the copy lies in the room.
  [[nodiscard]] bool holds(const Place& place) const;

  /// Pairs that are too near each other, ascending; pairs of places before `from` are left out.
  [[nodiscard]] std::vector<Touch> touches(const std::vector<Place>& places, std::size_t from = 0) const;

  /// Places without overlap by random sequential addition: each trial is kept unless it touches one kept before. Fewer
  /// than `count` where trial after trial touches.
  /// @param draw  the next trial
  [[nodiscard]] std::vector<Place> fill(std::size_t count, const std::function<Place()>& draw) const;

 private:
  void add_copy(const Place& place, std::vector<BodySpecification>& bodies) const;

  std::vector<BodySpecification> bodies_;
  Room room_;
};

/// Centres of `count` cells of the coarsest grid over a box that has as many; cells are as long as `spacing_m` is, in
/// proportion. Where the grid has more cells, the ones left empty are spread over it.
std::vector<Eigen::Vector3d> lattice_of(std::size_t count, const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m,
                                        const Eigen::Vector3d& spacing_m);

}  // namespace copepod::coupler
