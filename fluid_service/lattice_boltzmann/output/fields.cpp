#include "lattice_boltzmann/output/fields.hpp"

#include <stdexcept>
#include <utility>

namespace copepod::fluid {

namespace {

void add_to(std::vector<double>& sums, const std::vector<double>& values) {
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += values[i];
}

}  // namespace

void MeanField::add(const FieldBlock& block) {
  if (samples_++ == 0) {
    sums_ = block;
    return;
  }
  if (sums_.box != block.box) throw std::logic_error("samples of one mean cover different cells");
  add_to(sums_.density_kg_per_m3, block.density_kg_per_m3);
  add_to(sums_.velocity_m_per_s, block.velocity_m_per_s);
  sums_.body = block.body;
}

FieldBlock MeanField::mean() const {
  FieldBlock mean = sums_;
  const auto samples = static_cast<double>(samples_);
  for (double& value : mean.density_kg_per_m3) value /= samples;
  for (double& value : mean.velocity_m_per_s) value /= samples;
  return mean;
}

void MeanField::restore(std::int64_t samples, FieldBlock sums) {
  samples_ = samples;
  sums_ = std::move(sums);
}

std::vector<std::array<bool, 3>> MirrorImages::images() const {
  std::vector<std::array<bool, 3>> images;
  for (int bits = 0; bits < 8; ++bits) {
    const std::array<bool, 3> mirrored = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
    bool exists = true;
    for (int axis = 0; axis < 3; ++axis) exists = exists && (!mirrored[axis] || symmetric_[axis]);
    if (exists) images.push_back(mirrored);
  }
  return images;
}

FileBlock MirrorImages::image(const FieldBlock& block, const std::array<bool, 3>& mirrored) const {
  FileBlock file;
  Cell extent;
  for (int axis = 0; axis < 3; ++axis) {
    extent[axis] = block.box.extent(axis);
    file.box.low[axis] = mirrored[axis] ? domain_[axis] - block.box.high[axis] : block.box.low[axis];
    file.box.high[axis] = file.box.low[axis] + extent[axis];
  }
  const auto cells = static_cast<std::size_t>(block.box.volume());
  file.density_kg_per_m3.resize(cells);
  file.velocity_m_per_s.resize(3 * cells);
  file.body.resize(cells);
  std::size_t to = 0;
  for (std::int64_t z = 0; z < extent[2]; ++z)
    for (std::int64_t y = 0; y < extent[1]; ++y)
      for (std::int64_t x = 0; x < extent[0]; ++x, ++to) {
        const std::int64_t from_x = mirrored[0] ? extent[0] - 1 - x : x;
        const std::int64_t from_y = mirrored[1] ? extent[1] - 1 - y : y;
        const std::int64_t from_z = mirrored[2] ? extent[2] - 1 - z : z;
        const auto from = static_cast<std::size_t>((from_x * extent[1] + from_y) * extent[2] + from_z);
        file.density_kg_per_m3[to] = block.density_kg_per_m3[from];
        file.body[to] = block.body[from];
        for (std::size_t axis = 0; axis < 3; ++axis)
          file.velocity_m_per_s[3 * to + axis] =
              mirrored[axis] ? -block.velocity_m_per_s[3 * from + axis] : block.velocity_m_per_s[3 * from + axis];
      }
  return file;
}

}  // namespace copepod::fluid
