#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ranks/box.hpp"

namespace copepod::fluid {

/// One rank's share of the output fields, SI units; arrays in order (x, y, z), z fastest.
struct FieldBlock {
  Box box;                                ///< cells of the computed domain that this rank owns
  std::vector<double> density_kg_per_m3;  ///< shape (x, y, z)
  std::vector<double> velocity_m_per_s;   ///< shape (x, y, z, 3)
  std::vector<std::int32_t> body;         ///< shape (x, y, z); 0 fluid, else 1 + body index
};

/// Which steps enter a mean: `start` and every so many after it; steps completed, so never step 0.
struct Sampling {
  std::int64_t start = 0;
  std::int64_t every_steps = 1;

  bool operator==(const Sampling&) const = default;
};

/// Time mean of density and velocity: sums per cell in the order of the steps, so neither the number of ranks
/// nor a restart changes a bit.
class MeanField {
 public:
  /// @throws std::logic_error if the block covers other cells than the first one did
  void add(const FieldBlock& block);

  [[nodiscard]] std::int64_t samples() const { return samples_; }
  /// Sum / samples; `body` is that of the last sample. Needs a sample.
  [[nodiscard]] FieldBlock mean() const;

  /// For checkpoints: the sums, and how many samples are in them.
  [[nodiscard]] const FieldBlock& sums() const { return sums_; }
  void restore(std::int64_t samples, FieldBlock sums);

 private:
  std::int64_t samples_ = 0;
  FieldBlock sums_;
};

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
