#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/lattice/lattice_units.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"
#include "ranks/block_partition.hpp"

// Mirrors: symmetry planes and free-slip faces. The plane lies on cell faces, and beyond it is the fluid's
// own mirror image, so that a population comes back in its mirrored direction (d3q19::mirrored) to its own
// plane of cells: the normal momentum is reversed, the tangential one kept. They cost no time
// (PopulationLayout).

// Periodic faces: what leaves through one enters through the other. They cost no time: with streaming in
// place a population is stored where it enters, at the other end of the domain (PopulationLayout), or travels
// in a message to the rank that is there (HaloExchange).

namespace copepod::fluid {

/// Index in [0, cells) of the cell that `index` stands for.
constexpr std::int64_t wrapped(std::int64_t index, std::int64_t cells) { return ((index % cells) + cells) % cells; }

/// r − L round(r / L): one component of a distance, to the nearest image.
inline double to_nearest_image(double r, double length) {
  if (std::abs(r) < 0.49 * length) return r;  // without a division
  return r - length * std::round(r / length);
}

/// Index of the cell whose image is `index`, at most one period outside [0, cells).
constexpr std::int64_t reflected(std::int64_t index, std::int64_t cells) {
  return index < 0 ? -1 - index : 2 * cells - 1 - index;
}

/// Factors that turn loads on the visible part of a body into loads on the whole of it.
struct WholeBody {
  std::array<double, 3> force = {1.0, 1.0, 1.0};
  std::array<double, 3> torque = {1.0, 1.0, 1.0};

  /// A plane normal to `plane` cuts the body: what its symmetry forbids is zero (force normal to it, torque
  /// along it), the rest counts twice.
  constexpr void cut(std::size_t plane) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      force[axis] *= axis == plane ? 0.0 : 2.0;
      torque[axis] *= axis == plane ? 2.0 : 0.0;
    }
  }
};

/// What lies beyond a face of the computed domain. Where faces meet in an edge, the later kind wins.
enum class FaceKind {
  periodic,
  mirror,    ///< symmetry plane or free slip
  outflow,   ///< open_faces.hpp: fluid and sound leave
  pressure,  ///< open_faces.hpp: open, at a given density
  inflow,    ///< wall.hpp: as a wall, with fluid that comes in
  wall,      ///< wall.hpp: at rest or moving along itself
};

struct Face {
  FaceKind kind = FaceKind::wall;
  Eigen::Vector3d velocity_lu = Eigen::Vector3d::Zero();
  double excess_density_lu = 0.0;
  bool is_parabolic = false;
  bool removes_bodies = false;
  std::vector<double> profile = {};  ///< factors of the cells of the whole domain, the later axis fastest; none: 1
  std::optional<Signal> signal = {};
  double factor = 1.0;  ///< of the velocity in the step; before the first one a signal's differs from face to face, so
                        ///< that what walls add in an edge does not cancel

  [[nodiscard]] bool is_open() const { return kind == FaceKind::outflow || kind == FaceKind::pressure; }
};

/// Place of a face in arrays of six: x low, x high, y low, …
constexpr std::size_t face_index(int axis, bool high) { return 2 * static_cast<std::size_t>(axis) + (high ? 1 : 0); }

/// A link as the body sees it that it ends in: from r, relative to the body's centre, in a direction.
struct LinkToBody {
  Eigen::Vector3d r;
  int direction = 0;
};

/// The computed part of the domain: size, faces and symmetry; pure arithmetic on cell indices.
///
/// A symmetry plane through the middle of an axis halves the computed domain: the lower half is kept and its
/// upper face becomes a mirror.
class Domain {
 public:
  /// @throws CaseError if the domain has no cells, one periodic face only, or a symmetry plane inside a cell
  Domain(const FluidSetup& setup, const LatticeUnits& units);

  /// Of which the velocities of faces follow.
  void set_step(std::int64_t step) {
    for (Face& face : faces_)
      if (face.signal) face.factor = value_of(*face.signal, step, 0.5);
  }
  [[nodiscard]] bool varies() const {
    return std::ranges::any_of(faces_, [](const Face& face) { return face.signal.has_value(); });
  }

  [[nodiscard]] const Cell& cells() const { return cells_; }  ///< computed
  [[nodiscard]] const Face& face(int axis, bool high) const { return faces_[face_index(axis, high)]; }
  [[nodiscard]] bool periodic(int axis) const { return face(axis, false).kind == FaceKind::periodic; }
  [[nodiscard]] bool symmetric(int axis) const { return symmetric_[axis]; }
  [[nodiscard]] bool has_mirror(int axis) const {
    return face(axis, false).kind == FaceKind::mirror || face(axis, true).kind == FaceKind::mirror;
  }
  /// Factor of a face's velocity where the link from `ghost` in this direction meets it.
  [[nodiscard]] double profile(int axis, bool high, const Cell& ghost, int direction) const;
  /// How far moving bodies may reach beyond a face, where contacts hold them.
  [[nodiscard]] double wall_overlap_lu() const { return wall_overlap_lu_; }
  /// Whether a body with its centre there lies on the symmetry plane normal to `axis`, which shows half of
  /// it. Any other body is in the computed half, whole.
  [[nodiscard]] bool cut_by_symmetry_plane(const Eigen::Vector3d& position_lu, int axis) const {
    constexpr double tolerance = 1e-6;
    return symmetric_[axis] && std::abs(position_lu[axis] - static_cast<double>(cells_[axis])) < tolerance;
  }
  [[nodiscard]] Box box() const { return {{0, 0, 0}, cells_}; }

  /// The index that `index`, at most one cell outside, stands for along an axis: wrapped at periodic faces,
  /// reflected at mirrors. Empty beyond walls and open faces.
  [[nodiscard]] std::optional<std::int64_t> image(int axis, std::int64_t index) const;
  /// The same for a cell.
  [[nodiscard]] std::optional<Cell> canonical(const Cell& cell) const;
  /// Direction α mirrored at each mirror that `cell` is beyond.
  [[nodiscard]] int mirrored(int alpha, const Cell& cell) const;

  /// Vector from `position_lu` to the centre of `cell`, to the nearest periodic image.
  [[nodiscard]] Eigen::Vector3d from_position(const Eigen::Vector3d& position_lu, const Cell& cell) const {
    Eigen::Vector3d r;
    for (int axis = 0; axis < 3; ++axis) {
      r[axis] = (static_cast<double>(cell[axis]) + 0.5) - position_lu[axis];
      if (periodic(axis)) r[axis] = to_nearest_image(r[axis], static_cast<double>(cells_[axis]));
    }
    return r;
  }

  /// The link from `cell` in direction α to the nearest image of the body at `position_lu`, moved and mirrored
  /// with that image: beside a periodic face the image nearest to the link's end, through a mirror the image
  /// behind it.
  [[nodiscard]] LinkToBody link_to_body(const Eigen::Vector3d& position_lu, const Cell& cell, int direction) const;
  /// Those of the links from `cell` for which this differs from `r` and their own direction.
  /// @param r      from_position(position_lu, cell)
  /// @param links  bit α set: a link in direction α
  [[nodiscard]] std::uint32_t links_to_images(const Eigen::Vector3d& position_lu, const Eigen::Vector3d& r,
                                              const Cell& cell, std::uint32_t links) const {
    std::uint32_t result = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double half = 0.5 * static_cast<double>(cells_[axis]);
      const bool at_end = cell[axis] == 0 || cell[axis] == cells_[axis] - 1;
      if (periodic(axis) ? std::abs(r[axis]) < half - 1.0 : !at_end) continue;
      for (std::uint32_t bits = links; bits != 0; bits &= bits - 1) {
        const int alpha = std::countr_zero(bits);
        const int e = d3q19::e[alpha][axis];
        if (periodic(axis) ? std::abs(r[axis] + e) > half : through_mirror(position_lu, cell, axis, e))
          result |= 1U << alpha;
      }
    }
    return result;
  }

 private:
  /// Whether the step e along an axis leads through a mirror that does not cut the body.
  [[nodiscard]] bool through_mirror(const Eigen::Vector3d& position_lu, const Cell& cell, int axis, int e) const {
    const std::int64_t end = cell[axis] + e;
    if (end >= 0 && end < cells_[axis]) return false;
    return face(axis, end >= 0).kind == FaceKind::mirror && !(end >= 0 && cut_by_symmetry_plane(position_lu, axis));
  }

  Cell cells_;
  std::array<Face, 6> faces_;
  std::array<bool, 3> symmetric_;
  double wall_overlap_lu_;
};

/// Where the population comes from that leaves ghost cell g in direction α towards the domain.
struct GhostSource {
  enum class Kind {
    image,  ///< another cell, or the mirror image of one
    wall,   ///< the entered cell itself, bounced back
    open,   ///< the same, replaced by what an open face lets in
  } kind = Kind::image;
  Cell cell{};            ///< a cell of the computed domain, perhaps of another block
  int direction = 0;      ///< f̃ of that cell in this direction …
  double addition = 0.0;  ///< … plus this, at moving walls
  double profile = 1.0;   ///< of the face
  int axis = 0;           ///< of the face
  bool high = false;      ///< of the face
};

/// @param ghost      cell outside the domain or the block, at most by one
/// @param direction  α such that ghost + e_α is in the domain
GhostSource ghost_source(const Domain& domain, const Cell& ghost, int direction);

/// Where populations enter the cells on the faces of a block from: another rank's come from ghost cells, at
/// periodic faces from the other end, at mirrors from the cell's own plane, at walls and open faces from the
/// cell itself.
OriginRule origin_rule(const Domain& domain, const Box& block);

/// Calls visit(ghost, direction) for every ghost cell and direction that enters `block`, in a fixed order.
template <class Visit>
void for_each_entering(const Box& block, const Visit& visit) {
  for (int direction = 1; direction < d3q19::directions; ++direction) {
    const auto& e = d3q19::e[direction];
    for (std::int64_t x = block.low[0] - e[0]; x < block.high[0] - e[0]; ++x)
      for (std::int64_t y = block.low[1] - e[1]; y < block.high[1] - e[1]; ++y) {
        const bool row_inside = x >= block.low[0] && x < block.high[0] && y >= block.low[1] && y < block.high[1];
        if (!row_inside) {
          for (std::int64_t z = block.low[2] - e[2]; z < block.high[2] - e[2]; ++z) visit(Cell{x, y, z}, direction);
        } else if (e[2] != 0) {
          visit(Cell{x, y, e[2] > 0 ? block.low[2] - 1 : block.high[2]}, direction);
        }
      }
  }
}

}  // namespace copepod::fluid
