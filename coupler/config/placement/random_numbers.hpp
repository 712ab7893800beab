#pragma once

#include <cstdint>
#include <random>

#include <Eigen/Core>

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

}  // namespace copepod::coupler
