#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "contract/shape.hpp"

namespace copepod {

/// Part of a line, between two values of its parameter.
struct Interval {
  double low = 0.0;
  double high = 0.0;

  bool operator==(const Interval&) const = default;
};

/// Parts of a line inside a solid: ascending, none touches the next.
using Intervals = std::vector<Interval>;

/// Puts intervals in order and joins those that overlap or touch.
void unite(Intervals& intervals);

/// Integrals over a region: V = ∫ dV, ∫ x dV and ∫ x xᵀ dV.
struct VolumeMoments {
  double volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  [[nodiscard]] Eigen::Vector3d centre() const { return first / volume; }
  /// Inertia tensor about the origin for a density of 1: ∫ (|x|² 1 − x xᵀ) dV
  [[nodiscard]] Eigen::Matrix3d inertia() const { return second.trace() * Eigen::Matrix3d::Identity() - second; }
  /// Those of the region after x → R x + t.
  [[nodiscard]] VolumeMoments moved(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) const;
  VolumeMoments& operator+=(const VolumeMoments& other);
};

/// Points on a surface, and one strip of triangles: triangle i has the points i, i + 1, i + 2 of the strip, with its
/// front outwards if i is even. Some have no area.
struct Surface {
  Eigen::Matrix3Xd points;
  Eigen::Matrix3Xd normals;  ///< unit vectors, outwards
  std::vector<std::int32_t> strip;

  /// Appends another strip, by triangles without area.
  void join(const std::vector<std::int32_t>& next);

  /// visit(a, b, c) for triangles with three different points, counter-clockwise seen from outside.
  /// @param every  leaves out all but every so many
  template <class Visit>
  void for_each_triangle(const Visit& visit, std::size_t every = 1) const {
    for (std::size_t i = 0; i + 2 < strip.size(); i += every) {
      const std::int32_t a = strip[i], b = strip[i + 1 + i % 2], c = strip[i + 2 - i % 2];
      if (a != b && b != c && c != a) visit(a, b, c);
    }
  }
};

/// A closed region of space in a frame of its own, in any unit of length: all that is done with a shape. Each kind of
/// shape is one class.
class Solid {
 public:
  virtual ~Solid() = default;

  /// Of a ball around the origin that contains the solid.
  [[nodiscard]] virtual double bounding_radius() const = 0;

  /// The farthest point in a direction, of any length but 0.
  [[nodiscard]] virtual Eigen::Vector3d support(const Eigen::Vector3d& direction) const = 0;

  /// Where the line origin + t direction is inside.
  /// @param direction  of any length but 0
  /// @param inside     overwritten
  virtual void crossings(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Intervals& inside) const = 0;

  [[nodiscard]] virtual VolumeMoments moments() const = 0;

  /// @param around  points around an axis of round solids, a multiple of 4
  [[nodiscard]] virtual Surface surface(int around) const = 0;

  /// Whether a point lies inside.
  [[nodiscard]] bool contains(const Eigen::Vector3d& point) const;
};

/// @param unit_m  the unit of length of the solid
std::unique_ptr<Solid> make_solid(const Shape& shape, double unit_m = 1.0);

// One for each kind, from lengths in its own unit.
std::unique_ptr<Solid> make_capsule(double radius, double length);
std::unique_ptr<Solid> make_ellipsoid(const Eigen::Vector3d& semi_axes);
std::unique_ptr<Solid> make_cylinder(double radius, double length);
std::unique_ptr<Solid> make_mesh_solid(TriangleMesh mesh);

/// The surface of a box around the origin, of 12 triangles.
TriangleMesh box_mesh(const Eigen::Vector3d& edges);

/// A rotation none of whose axes is along what shapes usually have: faces and edges are hardly ever along them.
Eigen::Matrix3d oblique_frame();

/// A place that a closed surface of triangles encloses more than once, or with its front inside: it intersects itself,
/// or the shells it is made of overlap. Searched along 256 × 256 parallel lines.
std::optional<Eigen::Vector3d> enclosed_twice(const TriangleMesh& mesh);

/// Integrals of the parts of some parallel lines inside a solid: of any, and also where it overlaps with itself. Good
/// to about 1e-4 of the volume for compact solids.
VolumeMoments moments_by_lines(const Solid& solid);

/// Volume of a closed surface: V = Σ a·(b × c)/6 over its triangles, and the other moments likewise [Eberly 2002].
VolumeMoments moments_by_surface(const TriangleMesh& mesh);

}  // namespace copepod
