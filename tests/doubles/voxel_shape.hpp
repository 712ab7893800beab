#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "contract/shape.hpp"

namespace copepod::doubles {

inline bool is_in_voxels(const std::vector<std::array<int, 3>>& voxels, const Eigen::Vector3d& p) {
  return std::ranges::any_of(voxels, [&](const std::array<int, 3>& v) {
    return (p - Eigen::Vector3d(v[0], v[1], v[2])).array().floor().isZero(0.0);
  });
}

/// The surface of some unit cubes, given by their low corners, as a mesh, which is concave where they are; with
/// `centre`, in voxels, as its origin. The cubes must not touch along an edge only.
inline Shape voxel_shape(const std::vector<std::array<int, 3>>& voxels, double size, const Eigen::Vector3d& centre) {
  const std::set<std::array<int, 3>> filled(voxels.begin(), voxels.end());
  std::map<std::array<int, 3>, std::int32_t> numbers;
  std::vector<std::array<std::int32_t, 3>> triangles;
  const auto number = [&](const std::array<int, 3>& vertex) {
    return numbers.emplace(vertex, static_cast<std::int32_t>(numbers.size())).first->second;
  };
  for (const std::array<int, 3>& voxel : voxels)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        std::array<int, 3> beside = voxel;
        beside[axis] += 2 * side - 1;
        if (filled.contains(beside)) continue;
        std::array<std::int32_t, 4> corners{};
        for (std::size_t i = 0; i < 4; ++i) {
          std::array<int, 3> vertex = voxel;
          vertex[axis] += side;
          vertex[(axis + 1) % 3] += i == 1 || i == 2 ? 1 : 0;
          vertex[(axis + 2) % 3] += i >= 2 ? 1 : 0;
          corners[i] = number(vertex);
        }
        if (side == 0) std::swap(corners[1], corners[3]);
        triangles.push_back({corners[0], corners[1], corners[2]});
        triangles.push_back({corners[0], corners[2], corners[3]});
      }
  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(numbers.size()));
  for (const auto& [vertex, column] : numbers)
    vertices.col(column) = size * (Eigen::Vector3d(vertex[0], vertex[1], vertex[2]) - centre);
  TriangleMesh::Triangles corners(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      corners(j, static_cast<Eigen::Index>(i)) = triangles[i][static_cast<std::size_t>(j)];
  return {.kind = ShapeKind::mesh,
          .radius_m = size * std::cbrt(0.239 * static_cast<double>(voxels.size())),
          .mesh = std::make_shared<TriangleMesh>(vertices, corners)};
}

}  // namespace copepod::doubles
