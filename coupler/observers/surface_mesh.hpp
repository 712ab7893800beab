#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "contract/shape.hpp"

namespace copepod::coupler {

/// Surface of a shape in the body frame, as one closed strip of triangles: triangle i has the points i, i + 1, i + 2 of
/// the strip, with its front outwards if i is even.
struct SurfaceMesh {
  Eigen::Matrix3Xd points_m;  ///< on the surface
  Eigen::Matrix3Xd normals;   ///< unit vectors, outwards
  std::vector<std::int32_t> strip;
};

/// Rings of points around the body's z axis. Triangles without area join the bands between them.
/// @param around  points of a ring, a multiple of 4
SurfaceMesh surface_mesh(const Shape& shape, int around);

}  // namespace copepod::coupler
