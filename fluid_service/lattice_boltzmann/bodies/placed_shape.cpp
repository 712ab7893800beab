#include "lattice_boltzmann/bodies/placed_shape.hpp"

#include <algorithm>
#include <limits>

#include "geometry/shapes/solid.hpp"
#include "lattice_boltzmann/bodies/lattice_body.hpp"

namespace copepod::fluid {

namespace {

/// Lines are turned into the frame of the solid.
class PlacedSolid final : public PlacedShape {
 public:
  PlacedSolid(std::unique_ptr<const Solid> solid, const Eigen::Vector3d& position,
              const Eigen::Quaterniond& orientation)
      : PlacedShape(position, orientation), solid_(std::move(solid)), R_(orientation.toRotationMatrix()) {}

  [[nodiscard]] Eigen::AlignedBox3d bounds() const override {
    Eigen::AlignedBox3d bounds;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d direction = R_.row(axis);
      bounds.max()[axis] = direction.dot(solid_->support(direction));
      bounds.min()[axis] = direction.dot(solid_->support(-direction));
    }
    return bounds;
  }

  void add_crossings(std::vector<RowCrossing>& crossings) const override {
    for_each_row(bounds(), position(), [&](std::int64_t x, std::int64_t y) {
      const Eigen::Vector3d d = centre_of_cell(x, y, 0) - position();
      for (const auto& [low, high] : inside({d[0], d[1], 0.0}, Eigen::Vector3d::UnitZ()))
        append(crossings, x, y, cells_between(position()[2] + low, position()[2] + high));
    });
  }

  [[nodiscard]] double entry(const Eigen::Vector3d& r, int direction) const override {
    const auto& e = d3q19::velocity[direction];
    for (const auto& [low, high] : inside(r, {e[0], e[1], e[2]}))
      if (high > 0.0) return std::max(low, 0.0);
    return std::numeric_limits<double>::infinity();
  }

 private:
  [[nodiscard]] const Intervals& inside(const Eigen::Vector3d& r, const Eigen::Vector3d& direction) const {
    thread_local Intervals intervals;
    solid_->crossings(R_.transpose() * r, R_.transpose() * direction, intervals);
    return intervals;
  }

  std::unique_ptr<const Solid> solid_;
  Eigen::Matrix3d R_;
};

/// The union of its parts, each of which is placed by itself.
class PlacedCompound final : public PlacedShape {
 public:
  PlacedCompound(const std::vector<ShapePart>& parts, const Eigen::Vector3d& position,
                 const Eigen::Quaterniond& orientation, double cell_m)
      : PlacedShape(position, orientation) {
    for (const auto& [shape, position_m, q] : parts) {
      const Eigen::Vector3d from_centre = orientation * Eigen::Vector3d(position_m / cell_m);
      LatticeBody& part = parts_.emplace_back(shape, cell_m);
      part.place(position + from_centre, orientation * Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
      bounds_.extend(part.bounds().translated(from_centre));
    }
  }

  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return bounds_; }
  void add_crossings(std::vector<RowCrossing>& crossings) const override {
    for (const LatticeBody& part : parts_) fluid::add_crossings(part, crossings);
  }
  [[nodiscard]] double entry(const Eigen::Vector3d& r, int direction) const override {
    double q = std::numeric_limits<double>::infinity();
    for (const LatticeBody& part : parts_)
      q = std::min(q, fluid::entry(part, r - (part.position - position()), direction));
    return q;
  }

 private:
  std::vector<LatticeBody> parts_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace

std::shared_ptr<const PlacedShape> place(const Shape& shape, const Eigen::Vector3d& position,
                                         const Eigen::Quaterniond& orientation, double cell_m) {
  switch (shape.kind) {
    case ShapeKind::mesh:
      return place(*shape.mesh, position, orientation, cell_m);
    case ShapeKind::box:
      return place(box_mesh(shape.extents_m), position, orientation, cell_m);
    case ShapeKind::compound:
      return std::make_shared<PlacedCompound>(shape.parts, position, orientation, cell_m);
    default:
      return std::make_shared<PlacedSolid>(make_solid(shape, cell_m), position, orientation);
  }
}

}  // namespace copepod::fluid
