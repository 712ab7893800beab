#pragma once

#include <algorithm>
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

/// What a mirror plane does to a field: components along its normal change their sign if the field is a vector, the
/// others if it is an axial vector, like the vorticity.
enum class Reflection { scalar, vector, axial_vector };

/// Part of one field as it lies in an output file: order (z, y, x), x fastest, then the components.
template <class T>
struct FilePart {
  Box box;  ///< in the whole domain
  std::vector<T> values;
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
  /// Reorders the values of `block` to (z, y, x), those within `region` only. Along a mirrored axis of n cells, cell i
  /// becomes n − 1 − i.
  /// @param values  one per cell of a scalar, else three
  template <class T>
  [[nodiscard]] FilePart<T> image(const Box& block, const std::vector<T>& values, Reflection reflection,
                                  const std::array<bool, 3>& mirrored, const Box& region) const;

 private:
  Cell domain_;
  std::array<bool, 3> symmetric_;
};

template <class T>
FilePart<T> MirrorImages::image(const Box& block, const std::vector<T>& values, Reflection reflection,
                                const std::array<bool, 3>& mirrored, const Box& region) const {
  FilePart<T> part;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t low = mirrored[axis] ? domain_[axis] - block.high[axis] : block.low[axis];
    part.box.low[axis] = std::max(low, region.low[axis]);
    part.box.high[axis] = std::max(part.box.low[axis], std::min(low + block.extent(axis), region.high[axis]));
  }
  const std::size_t components = reflection == Reflection::scalar ? 1 : 3;
  const bool turned = reflection == Reflection::axial_vector && (mirrored[0] != mirrored[1]) != mirrored[2];
  std::array<T, 3> sign = {1, 1, 1};
  for (std::size_t axis = 0; axis < components && components > 1; ++axis)
    sign[axis] = mirrored[axis] != turned ? -1 : 1;
  const auto from = [&](int axis, std::int64_t cell) {
    return (mirrored[axis] ? domain_[axis] - 1 - cell : cell) - block.low[axis];
  };
  part.values.reserve(components * static_cast<std::size_t>(part.box.volume()));
  for (std::int64_t z = part.box.low[2]; z < part.box.high[2]; ++z)
    for (std::int64_t y = part.box.low[1]; y < part.box.high[1]; ++y)
      for (std::int64_t x = part.box.low[0]; x < part.box.high[0]; ++x) {
        const std::int64_t cell = (from(0, x) * block.extent(1) + from(1, y)) * block.extent(2) + from(2, z);
        for (std::size_t axis = 0; axis < components; ++axis)
          part.values.push_back(sign[axis] * values[components * static_cast<std::size_t>(cell) + axis]);
      }
  return part;
}

}  // namespace copepod::fluid
