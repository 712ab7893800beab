#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "geometry/periodic_images.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod {

/// How deep bodies overlap, periodic images included.
///
/// Of spheres and capsules,
///   depth = r_A + r_B − distance of the core segments                                        (B13)
/// Other shapes overlap where an edge of the triangles on one surface is inside the other; the depth is the least way
/// out along the axes of the other's frame. Where both are curved, an overlap of less than a thousandth of their radii
/// may not be found.
class Overlaps {
 public:
  Overlaps(std::vector<Shape> shapes, const PeriodicImages& images);

  /// @param position_m, orientation_wxyz  of all bodies; finite
  /// @return the largest over all images [m]; not positive: the bodies do not overlap. A body is not an image of itself
  [[nodiscard]] double depth_m(int A, int B, const Eigen::Matrix3Xd& position_m,
                               const Eigen::Matrix4Xd& orientation_wxyz) const;

  /// How deep edges on the surface of A are inside B: the same for a B of any size, and of many triangles.
  [[nodiscard]] double depth_inside_m(int A, int B, const Eigen::Matrix3Xd& position_m,
                                      const Eigen::Matrix4Xd& orientation_wxyz) const;

 private:
  struct Placed;
  template <class Depth>
  double deepest_m(int A, int B, const Eigen::Matrix3Xd& position_m, const Eigen::Matrix4Xd& orientation_wxyz,
                   const Depth& depth) const;

  std::vector<Shape> shapes_;
  std::vector<std::shared_ptr<const Solid>> solids_;  ///< none: all bodies are spheres or capsules
  PeriodicImages images_;
};

}  // namespace copepod
