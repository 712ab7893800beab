#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "contract/shape.hpp"

namespace copepod::fluid {

/// Where a row of cell centres along z enters a body (step 1) or leaves it (−1): `z` is the first cell beyond. Cells
/// are counted without wrapping.
struct RowCrossing {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t z = 0;
  int step = 0;
};

/// A shape other than sphere, capsule and ellipsoid at its place on the lattice; lengths in cells.
class PlacedShape {
 public:
  PlacedShape(Eigen::Vector3d position, const Eigen::Quaterniond& orientation)
      : position_(std::move(position)), orientation_(orientation) {}
  virtual ~PlacedShape() = default;

  [[nodiscard]] bool is_at(const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation) const {
    return position_ == position && orientation_.coeffs() == orientation.coeffs();
  }

  /// Axis-aligned bounding box, relative to the position.
  [[nodiscard]] virtual Eigen::AlignedBox3d bounds() const = 0;
  /// Appends the crossings of all rows, in any order. A cell is inside after more entries than exits.
  virtual void add_crossings(std::vector<RowCrossing>& crossings) const = 0;
  /// Where a link first enters, in its own length; infinity where it does so by rounding only.
  /// @param r  from the position to the cell centre where the link begins, outside the shape
  [[nodiscard]] virtual double entry(const Eigen::Vector3d& r, int direction) const = 0;

 protected:
  [[nodiscard]] const Eigen::Vector3d& position() const { return position_; }
  [[nodiscard]] const Eigen::Quaterniond& orientation() const { return orientation_; }

 private:
  Eigen::Vector3d position_;
  Eigen::Quaterniond orientation_;
};

/// @param position     finite, in cells
/// @param orientation  finite, of length 1
/// @param cell_m       width of a cell
std::shared_ptr<const PlacedShape> place(const Shape& shape, const Eigen::Vector3d& position,
                                         const Eigen::Quaterniond& orientation, double cell_m);
std::shared_ptr<const PlacedShape> place(const TriangleMesh& mesh, const Eigen::Vector3d& position,
                                         const Eigen::Quaterniond& orientation, double cell_m);

}  // namespace copepod::fluid
