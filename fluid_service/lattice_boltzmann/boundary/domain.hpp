#pragma once

#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/lattice/lattice_units.hpp"
#include "ranks/box.hpp"

namespace copepod::fluid {

/// What lies beyond a face of the computed domain.
enum class FaceKind {
  periodic,
  mirror,    ///< symmetry plane or free slip: the fluid's own mirror image; the plane lies on cell faces
  wall,      ///< half-way bounce-back, resting or moving tangentially or normally
  pressure,  ///< anti-bounce-back at a given density
};

struct Face {
  FaceKind kind = FaceKind::wall;
  Eigen::Vector3d velocity_lu = Eigen::Vector3d::Zero();
  double excess_density_lu = 0.0;
};

/// Place of a face in arrays of six: x low, x high, y low, …
constexpr std::size_t face_index(int axis, bool high) {
  return 2 * static_cast<std::size_t>(axis) + (high ? 1 : 0);
}

/// The computed part of the domain: size, faces and symmetry; pure arithmetic on cell indices.
///
/// A symmetry plane through the middle of an axis halves the computed domain: the lower half is kept and its
/// upper face becomes a mirror.
class Domain {
 public:
  Domain(const FluidSetup& setup, const LatticeUnits& units);

  [[nodiscard]] const Cell& cells() const { return cells_; }  ///< computed
  [[nodiscard]] const Face& face(int axis, bool high) const { return faces_[face_index(axis, high)]; }
  [[nodiscard]] bool periodic(int axis) const { return face(axis, false).kind == FaceKind::periodic; }
  [[nodiscard]] bool symmetric(int axis) const { return symmetric_[axis]; }
  /// Whether a body with its centre there lies on the symmetry plane normal to `axis`, which shows half of
  /// it. Any other body is in the computed half, whole.
  [[nodiscard]] bool cut_by_symmetry_plane(const Eigen::Vector3d& position_lu, int axis) const {
    constexpr double tolerance = 1e-6;
    return symmetric_[axis] && std::abs(position_lu[axis] - static_cast<double>(cells_[axis])) < tolerance;
  }
  [[nodiscard]] Box box() const { return {{0, 0, 0}, cells_}; }

  /// The domain cell that `cell`, at most one cell outside, stands for: wrapped at periodic faces, reflected
  /// at mirrors. Empty beyond walls and pressure faces.
  [[nodiscard]] std::optional<Cell> canonical(const Cell& cell) const;

  /// Vector from `position_lu` to the centre of `cell`, to the nearest periodic image.
  [[nodiscard]] Eigen::Vector3d from_position(const Eigen::Vector3d& position_lu, const Cell& cell) const;

 private:
  Cell cells_;
  std::array<Face, 6> faces_;
  std::array<bool, 3> symmetric_;
};

/// Where the population comes from that leaves ghost cell g in direction α towards the domain.
struct GhostSource {
  enum class Kind { copy, pressure } kind = Kind::copy;
  Cell cell{};                  ///< a cell of the computed domain, perhaps of another block
  int direction = 0;            ///< f̃ of that cell in this direction …
  double addition = 0.0;        ///< … plus this
  double excess_density = 0.0;  ///< for Kind::pressure
};

/// @param ghost      cell outside the domain or the block, at most by one
/// @param direction  α such that ghost + e_α is in the domain
GhostSource ghost_source(const Domain& domain, const Cell& ghost, int direction);

}  // namespace copepod::fluid
