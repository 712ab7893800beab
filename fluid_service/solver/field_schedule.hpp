#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "communication/communicator.hpp"
#include "contract/fluid_setup.hpp"
#include "output/field_writer.hpp"
#include "output/mean_field.hpp"

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

  [[nodiscard]] MeanField& mean() { return mean_; }

 private:
  [[nodiscard]] bool enters_mean(std::int64_t step) const;

  FieldOutput output_;
  std::unique_ptr<FieldWriter> writer_;  ///< none if nothing is to be written
  MeanField mean_;
};

}  // namespace copepod::fluid
