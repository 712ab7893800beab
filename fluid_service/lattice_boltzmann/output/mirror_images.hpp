#pragma once

#include <array>
#include <vector>

#include "lattice_boltzmann/output/field_block.hpp"

namespace copepod::fluid {

/// A block as it lies in an output file: arrays in order (z, y, x), x fastest.
struct FileBlock {
  Box box;  ///< in the whole domain
  std::vector<double> density_kg_per_m3;
  std::vector<double> velocity_m_per_s;  ///< shape (z, y, x, 3)
  std::vector<std::int32_t> body;
};

/// The copies of a computed block that make up the whole domain: mirror planes normal to some axes through
/// the domain's middle, the lower half computed. Arithmetic only.
class MirrorImages {
 public:
  MirrorImages(const Cell& domain_cells, const std::array<bool, 3>& symmetry_planes)
      : domain_(domain_cells), symmetric_(symmetry_planes) {}

  [[nodiscard]] const Cell& domain_cells() const { return domain_; }
  /// Which axes each image is mirrored along, the block itself (none) first: 1, 2, 4 or 8 images.
  [[nodiscard]] std::vector<std::array<bool, 3>> images() const;
  /// Reorders `block` to (z, y, x). Along a mirrored axis of n cells, cell i becomes n − 1 − i and the
  /// velocity component changes its sign.
  [[nodiscard]] FileBlock image(const FieldBlock& block, const std::array<bool, 3>& mirrored) const;

 private:
  Cell domain_;
  std::array<bool, 3> symmetric_;
};

}  // namespace copepod::fluid
