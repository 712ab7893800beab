#include "lattice_boltzmann/output/field_schedule.hpp"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

namespace copepod::fluid {

namespace {

/// @param found  samples in the checkpoint
/// @param due    samples that there should be, of other steps
void warn_of_other_steps(std::int64_t found, std::int64_t due, std::int64_t step) {
  if (found > 0)
    spdlog::warn(
        "The {} samples of the checkpoint's mean field are left out (the case asks for other steps).", found);
  if (due > 0)
    spdlog::warn(
        "The mean field will lack {} samples (they are of steps up to {}, from where the run is resumed). "
        "Resume with the mean_over_steps and mean_every_steps of the run before, or start anew.",
        due, step);
}

}  // namespace

FieldSchedule::FieldSchedule(const FluidSetup& setup, Communicator& communicator)
    : output_(setup.fields), is_leader_(communicator.rank() == 0) {
  if (output_.every_steps > 0 || output_.mean_stop > 0)
    writer_ = std::make_unique<FieldWriter>(output_, setup, communicator);
}

FieldSchedule::~FieldSchedule() = default;

bool FieldSchedule::enters_mean(std::int64_t step) const {
  return step >= output_.mean_start && step < output_.mean_stop &&
         (step - output_.mean_start) % output_.mean_every_steps == 0;
}

/// How many of the steps up to `step` enter the mean.
std::int64_t FieldSchedule::samples_by(std::int64_t step) const {
  if (output_.mean_stop == 0) return 0;
  const std::int64_t first = output_.mean_start > 0 ? output_.mean_start : output_.mean_every_steps;
  const std::int64_t last = std::min(step, output_.mean_stop - 1);
  return last < first ? 0 : 1 + (last - first) / output_.mean_every_steps;
}

void FieldSchedule::restore(std::int64_t step, const Sampling& sampling, MeanField mean) {
  const std::int64_t due = samples_by(step);
  const bool same_steps = mean.samples() == due && (due == 0 || sampling == this->sampling());
  if (!same_steps && is_leader_) warn_of_other_steps(mean.samples(), due, step);
  mean_ = same_steps ? std::move(mean) : MeanField{};
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
