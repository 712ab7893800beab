#pragma once

#include <vector>

#include <Eigen/Core>

/// A forcing point of a body: where it is, and the volume that it stands for.
struct Point {
  Eigen::Vector3d place_lu;  ///< from the centre, body frame
  double volume_lu = 0.0;
};

/// Points that fill a sphere or capsule in shells one cell thick, each shell in rings about the body's z axis. Their
/// volumes add up to that of the body; they are symmetric about the planes x, y and z.
/// @param half_length_lu  half the cylinder's length, 0 for a sphere
/// @param retraction_lu   depth of the outermost points below the surface
std::vector<Point> fill_body(double radius_lu, double half_length_lu, double retraction_lu);
