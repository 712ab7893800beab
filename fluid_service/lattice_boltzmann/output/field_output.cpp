#include "lattice_boltzmann/output/field_output.hpp"

#include <algorithm>
#include <filesystem>
#include <span>
#include <utility>

#include <spdlog/spdlog.h>

#include "files/shared_file.hpp"
#include "lattice_boltzmann/output/xdmf.hpp"
#include "system/durable_file.hpp"

namespace copepod::fluid {

namespace {

using Extent = Hdf5File::Extent;

const std::string data_file = "fields.h5";
const std::string description_file = "fields.xdmf";
constexpr std::int64_t bytes_per_cell = 4 * sizeof(double) + sizeof(std::int32_t);
constexpr std::int64_t structure_bytes = 1 << 16;   ///< more than HDF5 needs to describe a group
const std::string unfinished_group = "unfinished";  ///< name of a group that is being written

Extent in_file_order(const Cell& cell) {
  return {static_cast<std::uint64_t>(cell[2]), static_cast<std::uint64_t>(cell[1]),
          static_cast<std::uint64_t>(cell[0])};
}

Extent with(Extent extent, std::uint64_t last) {
  extent.push_back(last);
  return extent;
}

/// @param found  samples in the checkpoint
/// @param due    samples that there should be, of other steps
void warn_of_other_steps(std::int64_t found, std::int64_t due, std::int64_t step) {
  if (found > 0)
    spdlog::warn("The {} samples of the checkpoint's mean field are left out (the case asks for other steps).", found);
  if (due > 0)
    spdlog::warn(
        "The mean field will lack {} samples (they are of steps up to {}, from where the run is resumed). "
        "Resume with the mean_over_steps and mean_every_steps of the run before, or start anew.",
        due, step);
}

}  // namespace

FieldWriter::FieldWriter(const FieldOutput& output, const FluidSetup& setup, Communicator& communicator)
    : output_(output),
      path_(output.directory + "/" + data_file),
      step_s_(setup.step_s),
      cell_size_m_(setup.cell_size_m),
      images_(setup.domain_cells, setup.symmetry_planes),
      communicator_(communicator) {}

FieldWriter::Offsets FieldWriter::lay_out(const Attributes& attributes) const {
  const Cell& cells = images_.domain_cells();
  const bool exists = std::filesystem::exists(path_) && std::filesystem::file_size(path_) > 0;
  require_space(path_, cells[0] * cells[1] * cells[2] * bytes_per_cell + structure_bytes, communicator_.context());
  Hdf5File file(path_, exists ? Hdf5File::Access::extend : Hdf5File::Access::create, communicator_.context());
  if (file.has(unfinished_group)) file.remove(unfinished_group);  // of a run that was killed
  file.make_group(unfinished_group);
  file.write_attribute(unfinished_group, "cell_size_m", cell_size_m_);
  file.write_attribute(unfinished_group, "step_s", step_s_);
  attributes(file, unfinished_group);
  const Extent shape = in_file_order(cells);
  Offsets offsets;
  offsets.density = file.make_dataset<double>(unfinished_group + "/density_kg_per_m3", shape);
  offsets.velocity = file.make_dataset<double>(unfinished_group + "/velocity_m_per_s", with(shape, 3));
  offsets.body = file.make_dataset<std::int32_t>(unfinished_group + "/body", shape);
  file.close();
  reserve_space(path_, communicator_.context());
  return offsets;
}

void FieldWriter::write_cells(const Offsets& offsets, const FieldBlock& block) const {
  const Extent shape = in_file_order(images_.domain_cells());
  SharedFile file(path_, communicator_.context());
  for (const auto& mirrored : images_.images()) {
    const FileBlock image = images_.image(block, mirrored);
    const Extent start = in_file_order(image.box.low);
    const Extent count = in_file_order({image.box.extent(0), image.box.extent(1), image.box.extent(2)});
    file.write(offsets.density, shape, start, count, image.density_kg_per_m3.data());
    file.write(offsets.velocity, with(shape, 3), with(start, 0), with(count, 3), image.velocity_m_per_s.data());
    file.write(offsets.body, shape, start, count, image.body.data());
  }
}

void FieldWriter::publish(const std::string& group) const {
  Hdf5File file(path_, Hdf5File::Access::extend, communicator_.context());
  if (file.has(group)) file.remove(group);  // from before a restart
  file.rename(unfinished_group, group);
  XdmfDescription description;
  description.cells = images_.domain_cells();
  description.cell_size_m = cell_size_m_;
  description.step_s = step_s_;
  description.data_file = data_file;
  description.groups = file.names();
  file.close();
  const std::string text = xdmf_text(description);
  write_durably(output_.directory + "/" + description_file, std::as_bytes(std::span(text)));
}

void FieldWriter::write(const std::string& group, const FieldBlock& block, const Attributes& attributes) {
  Offsets offsets;
  on_leader(communicator_, [&] { offsets = lay_out(attributes); });
  communicator_.broadcast(std::as_writable_bytes(std::span(&offsets, 1)));
  on_every_rank(communicator_, [&] { write_cells(offsets, block); });
  on_leader(communicator_, [&] { publish(group); });
}

void FieldWriter::write_snapshot(std::int64_t step, const FieldBlock& block) {
  write(group_of_step(step), block, [&](Hdf5File& file, const std::string& group) {
    file.write_attribute(group, "step", step);
    file.write_attribute(group, "time_s", static_cast<double>(step) * step_s_);
  });
}

void FieldWriter::write_mean(std::int64_t samples, const FieldBlock& block) {
  write("mean", block, [&](Hdf5File& file, const std::string& group) {
    file.write_attribute(group, "samples", samples);
    file.write_attribute(group, "mean_start", output_.mean_start);
    file.write_attribute(group, "mean_stop", output_.mean_stop);
    file.write_attribute(group, "mean_every_steps", output_.mean_every_steps);
  });
}

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
