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

}  // namespace copepod::fluid
