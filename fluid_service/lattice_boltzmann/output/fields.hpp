#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/communicator.hpp"

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

/// An array of each group of fields.h5.
struct FieldArray {
  const char* name = "";
  std::optional<FieldQuantity> quantity;  ///< that a case asks for; none: the array is always there
  Reflection reflection = Reflection::scalar;

  [[nodiscard]] bool is_vector() const { return reflection != Reflection::scalar; }
};

inline constexpr std::array field_arrays{
    FieldArray{"density_kg_per_m3", FieldQuantity::density}, FieldArray{"pressure_Pa", FieldQuantity::pressure},
    FieldArray{"velocity_m_per_s", FieldQuantity::velocity, Reflection::vector},
    FieldArray{"vorticity_per_s", FieldQuantity::vorticity, Reflection::axial_vector}, FieldArray{"body", {}}};

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

/// Gradient of a rank's velocities, by central differences.
///   ∂u/∂x ≈ (u(x + Δx) − u(x − Δx)) / (2 Δx)
/// Cells of bodies have the velocity of the surface that covers them. Beyond a mirror lies the mirror image, beyond a
/// wall 2 u_wall − u, which is exact for linear flow; beside an open face, or one whose velocity varies in place or
/// time, the difference is one-sided. One layer of velocities travels between ranks, so every decomposition gives the
/// same bits.
class VelocityGradient {
 public:
  /// Collective.
  /// @param setup         with the bodies by which the cells are cut into blocks
  /// @param block         that of BlockPartition
  VelocityGradient(const FluidSetup& setup, const FieldBlock& block, Communicator& communicator);

  /// Δx ∂u_i/∂x_j in a cell of the block [m/s].
  [[nodiscard]] Eigen::Matrix3d operator()(const Cell& cell) const {
    const std::int64_t at = layout_.cell(cell);
    Eigen::Matrix3d gradient;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) gradient(i, j) = 0.5 * (u_[i][at + stride_[j]] - u_[i][at - stride_[j]]);
    return gradient;
  }

 private:
  void fill_ghosts(Communicator& communicator);
  [[nodiscard]] int rank_beyond(int axis, bool high) const;
  /// Of the block, the cells along an axis that are next to a face, or beyond it.
  [[nodiscard]] Box layer(int axis, bool high, bool beyond) const;
  void fill_locally(int axis, bool high);

  double unit_;  ///< of the velocities: one cell per step
  Domain domain_;
  BlockPartition partition_;
  PopulationLayout layout_;
  std::array<std::int64_t, 3> stride_;  ///< of indices, by axis
  std::array<std::vector<double>, 3> u_;
};

/// Vorticity ω = ∇ × u of the velocity field of output [1/s], zero in cells of bodies; collective.
/// @return shape (x, y, z, 3) as the velocity
std::vector<double> vorticity(const FluidSetup& setup, const FieldBlock& block, Communicator& communicator);

/// One group of fields.h5 as ParaView sees it.
struct XdmfGrid {
  std::string group;  ///< "step_000001000" or "mean"
  std::string file;   ///< that holds it; from the folder of the XDMF file
  Box box;            ///< its cells, in the whole domain
  std::vector<std::string> datasets;

  bool operator==(const XdmfGrid&) const = default;
};

/// XDMF 2 text for ParaView: snapshots as a temporal collection, or the mean as one grid without a time. Fields belong
/// to the cells.
std::string xdmf_text(double cell_size_m, double step_s, const std::vector<XdmfGrid>& grids);

/// Step of a snapshot group, −1 for other groups.
std::int64_t step_of_group(const std::string& group);
std::string group_of_step(std::int64_t step);

}  // namespace copepod::fluid
