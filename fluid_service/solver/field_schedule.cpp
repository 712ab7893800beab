#include "solver/field_schedule.hpp"

namespace copepod::fluid {

FieldSchedule::FieldSchedule(const FluidSetup& setup, Communicator& communicator) : output_(setup.fields) {
  if (output_.every_steps > 0 || output_.mean_stop > 0)
    writer_ = std::make_unique<FieldWriter>(output_, setup, communicator);
}

FieldSchedule::~FieldSchedule() = default;

bool FieldSchedule::enters_mean(std::int64_t step) const {
  return step >= output_.mean_start && step < output_.mean_stop &&
         (step - output_.mean_start) % output_.mean_every_steps == 0;
}

void FieldSchedule::after_step(std::int64_t step, const std::function<FieldBlock()>& fields) {
  if (!writer_) return;
  const bool snapshot = output_.every_steps > 0 && step % output_.every_steps == 0;
  const bool sample = enters_mean(step);
  if (snapshot || sample) {
    const FieldBlock block = fields();
    if (snapshot) writer_->write_snapshot(step, block);
    if (sample) mean_.add(block);
  }
  if (step == output_.mean_stop && mean_.samples() > 0) writer_->write_mean(mean_.samples(), mean_.mean());
}

}  // namespace copepod::fluid
