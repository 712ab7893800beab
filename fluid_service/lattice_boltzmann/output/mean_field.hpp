#pragma once

#include <cstdint>

#include "lattice_boltzmann/output/field_block.hpp"

namespace copepod::fluid {

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

}  // namespace copepod::fluid
