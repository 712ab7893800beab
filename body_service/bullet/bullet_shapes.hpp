#pragma once

#include <btBulletDynamicsCommon.h>
#include <memory>
#include <string>
#include <vector>

#include "contract/shape.hpp"

namespace copepod::body {

using BulletShapes = std::vector<std::unique_ptr<btCollisionShape>>;

/// Bullet's form of a shape; ellipsoids and cylinders are smooth, meshes must be convex.
/// @param unit_m  of length
/// @param body    for the error
/// @param kept    owns it and its parts
/// @throws CaseError naming the body if a mesh is concave
btCollisionShape* bullet_shape(const Shape& shape, double unit_m, const std::string& body, BulletShapes& kept);

}  // namespace copepod::body
