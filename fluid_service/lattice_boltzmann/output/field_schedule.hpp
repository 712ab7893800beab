#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/output/field_writer.hpp"
#include "lattice_boltzmann/output/mean_field.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Decides after which steps fields are written or enter the mean; collective.
class FieldSchedule {
 public:
  FieldSchedule(const FluidSetup& setup, Communicator& communicator);
  ~FieldSchedule();

  /// @param step    steps completed
  /// @param fields  computes this rank's fields; called only when they are wanted
  /// @throws StorageError
  void after_step(std::int64_t step, const std::function<FieldBlock()>& fields);

  /// For checkpoints: the sums so far, and the steps that they are of.
  [[nodiscard]] const MeanField& mean() const { return mean_; }
  [[nodiscard]] Sampling sampling() const { return {output_.mean_start, output_.mean_every_steps}; }

  /// Goes on after `step` with the sums of a checkpoint if they are of the very steps that would be in the
  /// mean by then. Otherwise the sums start anew, since a run may be resumed with another mean, and the log
  /// says what is missing.
  void restore(std::int64_t step, const Sampling& sampling, MeanField mean);

 private:
  [[nodiscard]] bool enters_mean(std::int64_t step) const;
  [[nodiscard]] std::int64_t samples_by(std::int64_t step) const;

  FieldOutput output_;
  bool is_leader_;
  std::unique_ptr<FieldWriter> writer_;  ///< none if nothing is to be written
  MeanField mean_;
};

}  // namespace copepod::fluid
