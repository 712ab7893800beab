#include "lattice_boltzmann/output/field_output.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <span>
#include <utility>

#include <spdlog/fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "contract/errors.hpp"
#include "system/durable_file.hpp"

namespace copepod::fluid {

namespace {

using Extent = Hdf5File::Extent;

const std::string index_file = "fields.h5";
const std::string folder = "fields";               ///< of files with a group each
constexpr std::int64_t structure_bytes = 1 << 16;  ///< more than HDF5 needs to describe a group
constexpr std::int64_t link_bytes = 1 << 9;        ///< likewise, a link to one

const std::string mean_group = "mean";

/// Attributes of a group that place its cells in the domain.
constexpr std::array region_attributes = {"first_cell_x", "first_cell_y", "first_cell_z",
                                          "cells_x",      "cells_y",      "cells_z"};

bool asks_for(const FieldOutput& output, const std::optional<FieldQuantity>& quantity) {
  if (!quantity) return true;
  if (output.quantities.empty()) return quantity == FieldQuantity::density || quantity == FieldQuantity::velocity;
  return std::ranges::find(output.quantities, *quantity) != output.quantities.end();
}

Box region_of(const FieldOutput& output, const Cell& domain_cells) {
  Box region{{0, 0, 0}, domain_cells};
  for (std::size_t axis = 0; axis < 3 && !output.region_cells.empty(); ++axis) {
    const std::int64_t stop = output.region_cells[2 * axis + 1];
    if (stop == 0) continue;
    region.low[axis] = output.region_cells[2 * axis];
    region.high[axis] = std::min(stop, domain_cells[axis]);
    if (region.low[axis] >= region.high[axis])
      throw CaseError("fields.region_cells starts at cell " + std::to_string(region.low[axis]) + " of " +
                      std::to_string(domain_cells[axis]) + " (nothing would be written). Use cells of the domain.");
  }
  return region;
}

Extent in_file_order(const Cell& cell) { return {cell.rbegin(), cell.rend()}; }

/// Shape in the file: (z, y, x) of a scalar, (z, y, x, 3) of a vector.
Extent shape_of(const Box& box, bool is_vector) {
  const Extent shape = in_file_order({box.extent(0), box.extent(1), box.extent(2)});
  return is_vector ? Hdf5File::with(shape, 3) : shape;
}

std::string group_in(Hdf5File& file, const InitialFlow& flow) {
  const std::vector<std::string> names = file.names();
  const auto newest = std::ranges::max_element(names, {}, step_of_group);
  if (flow.group == "newest" && newest != names.end() && step_of_group(*newest) >= 0) return *newest;
  if (std::ranges::find(names, flow.group) != names.end()) return flow.group;
  throw CaseError(flow.file + " has no group " + (flow.group == "newest" ? "of a step" : flow.group) +
                  " (output.fields writes step_000001000 and the like). Name one that it has in initial_flow.group.");
}

/// @return values in file order
std::vector<double> read_array(Hdf5File& file, const std::string& name, bool is_vector, const FluidSetup& setup,
                               const Box& box) {
  const Extent found = file.shape(name), needed = shape_of({{0, 0, 0}, setup.domain_cells}, is_vector);
  if (found != needed)
    throw CaseError(
        fmt::format("{} has {} values in {}, not {} (one for every cell along z, y, x{}). Use a file of as many cells, "
                    "or change domain_cells.",
                    setup.initial_flow.file, fmt::join(found, " × "), name, fmt::join(needed, " × "),
                    is_vector ? ", with three components" : ""));
  std::vector<double> values(static_cast<std::size_t>(box.volume()) * (is_vector ? 3 : 1));
  const Extent start = in_file_order(box.low);
  file.read(name, is_vector ? Hdf5File::with(start, 0) : start, shape_of(box, is_vector), values.data());
  return values;
}

/// ρ/ρ₀ − 1 in file order.
std::vector<double> read_excess_density(Hdf5File& file, const std::string& group, const FluidSetup& setup,
                                        const Box& box) {
  const std::string pressure = group + "/pressure_Pa", density = group + "/density_kg_per_m3";
  std::vector<double> values(box.volume());
  if (file.has(pressure)) {
    values = read_array(file, pressure, false, setup, box);
    for (double& value : values) value = LatticeUnits(setup).excess_density_lu(value);
  } else if (file.has(density)) {
    const double speed =
        file.read_attribute<double>(group, "cell_size_m") / file.read_attribute<double>(group, "step_s");
    const double ratio = speed / (setup.cell_size_m / setup.step_s);  // p = c_s² (ρ − ρ₀) is the same in both units
    values = read_array(file, density, false, setup, box);
    for (double& value : values) value = ratio * ratio * (value / setup.density_kg_per_m3 - 1.0);
  }
  return values;
}

/// @param found  samples in the checkpoint
/// @param due    samples that there should be, of other steps
void warn_of_other_steps(std::int64_t found, std::int64_t due, std::int64_t step) {
  if (found > 0)
    spdlog::warn("The {} samples of the checkpoint's mean field are left out (the case asks for other steps).", found);
  if (due > 0)
    spdlog::warn(
        "The mean field will lack {} samples (they are of steps up to {}, from where the run is resumed). Resume with "
        "the mean_over_steps and mean_every_steps of the run before, or start anew.",
        due, step);
}

}  // namespace

FieldWriter::FieldWriter(const FieldOutput& output, const FluidSetup& setup, Communicator& communicator)
    : output_(output),
      region_(region_of(output, setup.domain_cells)),
      unfinished_path_(in_run(folder) + "/unfinished"),
      cells_path_(output.compression > 0 ? in_run(folder) + "/uncompressed" : unfinished_path_),
      units_(setup),
      step_s_(setup.step_s),
      cell_size_m_(setup.cell_size_m),
      images_(setup.domain_cells, setup.symmetry_planes),
      communicator_(communicator) {
  for (const FieldArray& array : field_arrays)
    if (asks_for(output, array.quantity)) arrays_.push_back(array);
  if (asks_for(output, FieldQuantity::vorticity))
    vorticity_ = [setup, &communicator](const FieldBlock& block) { return vorticity(setup, block, communicator); };
  offsets_.resize(arrays_.size());
}

std::string FieldWriter::in_run(const std::string& file) const { return output_.directory + "/" + file; }

Extent FieldWriter::shape(const FieldArray& array) const { return shape_of(region_, array.is_vector()); }

std::int64_t FieldWriter::data_bytes() const {
  std::int64_t bytes = 0;
  for (const FieldArray& array : arrays_) bytes += (array.is_vector() ? 3 : 1) * std::int64_t{sizeof(double)};
  return bytes * region_.volume();
}

/// Finds the groups that are there when a run is resumed.
void FieldWriter::find_groups() {
  std::error_code error;
  std::filesystem::create_directory(in_run(folder), error);
  if (error)
    throw StorageError(in_run(folder) + ": cannot make this folder (" + error.message() +
                       "). Make room on the disk, check permissions, and resume.");
  for (const auto& entry : std::filesystem::directory_iterator(in_run(folder)))
    if (entry.path().extension() == ".h5") add_groups_of(folder + "/" + entry.path().filename().string());
}

void FieldWriter::add_groups_of(const std::string& name) {
  Hdf5File file(in_run(name), Hdf5File::Access::read, communicator_.context());
  for (const std::string& group : file.names()) {
    if (step_of_group(group) < 0 && group != mean_group) continue;
    XdmfGrid grid{group, name, {}, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      grid.box.low[axis] = file.read_attribute<std::int64_t>(group, region_attributes[axis]);
      grid.box.high[axis] = grid.box.low[axis] + file.read_attribute<std::int64_t>(group, region_attributes[axis + 3]);
    }
    for (const FieldArray& array : field_arrays)
      if (file.has(group + "/" + array.name)) grid.datasets.emplace_back(array.name);
    grids_[group] = grid;
  }
}

/// Makes a file that has room for so many bytes.
Hdf5File FieldWriter::new_file(const std::string& path, std::int64_t bytes) const {
  std::filesystem::remove(path);  // of a run that was killed: its space counts as free
  require_space(path, bytes, communicator_.context());
  return {path, Hdf5File::Access::create, communicator_.context()};
}

void FieldWriter::make_group(Hdf5File& file, const std::string& group, const Attributes& attributes) const {
  file.make_group(group);
  file.write_attribute(group, "cell_size_m", cell_size_m_);
  file.write_attribute(group, "step_s", step_s_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    file.write_attribute(group, region_attributes[axis], region_.low[axis]);
    file.write_attribute(group, region_attributes[axis + 3], region_.extent(static_cast<int>(axis)));
  }
  attributes(file);
}

void FieldWriter::lay_out(const std::string& group, const Attributes& attributes) {
  if (grids_.empty()) find_groups();
  Hdf5File file = new_file(cells_path_, data_bytes() + structure_bytes);
  make_group(file, group, attributes);
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    const std::string name = group + "/" + arrays_[i].name;
    offsets_[i] = arrays_[i].quantity ? file.make_dataset<double>(name, shape(arrays_[i]))
                                      : file.make_dataset<std::int32_t>(name, shape(arrays_[i]));
  }
  file.close();
  reserve_space(cells_path_, communicator_.context());
}

template <class T>
void FieldWriter::write_values(SharedFile& file, std::size_t array, const Box& box,
                               const std::vector<T>& values) const {
  const bool is_vector = arrays_[array].is_vector();
  for (const auto& mirrored : images_.images()) {
    const FilePart<T> part = images_.image(box, values, arrays_[array].reflection, mirrored, region_);
    if (part.values.empty()) continue;
    const Extent start = in_file_order(
        {part.box.low[0] - region_.low[0], part.box.low[1] - region_.low[1], part.box.low[2] - region_.low[2]});
    file.write(offsets_[array], shape_of(region_, is_vector), is_vector ? Hdf5File::with(start, 0) : start,
               shape_of(part.box, is_vector), part.values.data());
  }
}

void FieldWriter::write_cells(const FieldBlock& block) const {
  // Collective, and therefore before anything that can fail on one rank.
  const std::vector<double> vorticity = vorticity_ ? vorticity_(block) : std::vector<double>{};
  on_every_rank(communicator_, [&] {
    SharedFile file(cells_path_, communicator_.context());
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      const std::optional<FieldQuantity>& quantity = arrays_[i].quantity;
      if (!quantity) {
        write_values(file, i, block.box, block.body);
      } else if (quantity == FieldQuantity::pressure) {
        std::vector<double> pressure = block.density_kg_per_m3;
        for (double& value : pressure) value = units_.pressure_Pa(value);
        write_values(file, i, block.box, pressure);
      } else {
        write_values(file, i, block.box,
                     quantity == FieldQuantity::density    ? block.density_kg_per_m3
                     : quantity == FieldQuantity::velocity ? block.velocity_m_per_s
                                                           : vorticity);
      }
    }
  });
}

void FieldWriter::compress(const std::string& group, const Attributes& attributes) const {
  Hdf5File file = new_file(unfinished_path_, data_bytes() + structure_bytes);
  make_group(file, group, attributes);
  Hdf5File source(cells_path_, Hdf5File::Access::read, communicator_.context());
  for (const FieldArray& array : arrays_) {
    const std::string name = group + "/" + array.name;
    if (array.quantity)
      file.copy_compressed<double>(source, name, shape(array), output_.compression);
    else
      file.copy_compressed<std::int32_t>(source, name, shape(array), output_.compression);
  }
  file.close();
  std::filesystem::remove(cells_path_);
}

void FieldWriter::publish(const std::string& group) {
  const std::string file = folder + "/" + group + ".h5", new_index = in_run(folder) + "/index";
  std::filesystem::rename(unfinished_path_, in_run(file));
  add_groups_of(file);
  const auto groups = static_cast<std::int64_t>(grids_.size());
  Hdf5File index = new_file(new_index, structure_bytes + groups * link_bytes);
  for (const auto& [name, grid] : grids_) index.link(name, grid.file);
  index.close();
  copepod::publish(new_index, in_run(index_file));
  std::vector<XdmfGrid> shown;
  for (const auto& [name, grid] : grids_)
    if ((name == mean_group) == (group == mean_group)) shown.push_back(grid);
  write_durably(in_run(group == mean_group ? "fields_mean.xdmf" : "fields.xdmf"),
                xdmf_text(cell_size_m_, step_s_, shown));
}

void FieldWriter::write(const std::string& group, const FieldBlock& block, const Attributes& attributes) {
  on_leader(communicator_, [&] { lay_out(group, attributes); });
  communicator_.broadcast(std::as_writable_bytes(std::span(offsets_)));
  write_cells(block);
  on_leader(communicator_, [&] {
    if (cells_path_ != unfinished_path_) compress(group, attributes);
    publish(group);
  });
}

void FieldWriter::write_snapshot(std::int64_t step, const FieldBlock& block) {
  const std::string group = group_of_step(step);
  write(group, block, [&](Hdf5File& file) {
    file.write_attribute(group, "step", step);
    file.write_attribute(group, "time_s", static_cast<double>(step) * step_s_);
    file.write_attribute(group, "step_of_bodies", std::max<std::int64_t>(step - 1, 0));  // of the last exchange
  });
}

void FieldWriter::write_mean(std::int64_t samples, const FieldBlock& block) {
  write(mean_group, block, [&](Hdf5File& file) {
    file.write_attribute(mean_group, "samples", samples);
    file.write_attribute(mean_group, "mean_start", output_.mean_start);
    file.write_attribute(mean_group, "mean_stop", output_.mean_stop);
    file.write_attribute(mean_group, "mean_every_steps", output_.mean_every_steps);
  });
}

FieldSchedule::FieldSchedule(const FluidSetup& setup, Communicator& communicator)
    : output_(setup.fields), is_leader_(communicator.rank() == 0) {
  if (output_.every_steps > 0 || output_.mean_stop > 0) writer_.emplace(output_, setup, communicator);
}

bool FieldSchedule::enters_mean(std::int64_t step) const {
  return step >= output_.mean_start && step < output_.mean_stop &&
         (step - output_.mean_start) % output_.mean_every_steps == 0;
}

/// How many of the steps up to `step` enter the mean. Step 0 does as the first one begins: a state of step 0 lacks it.
std::int64_t FieldSchedule::samples_by(std::int64_t step) const {
  const std::int64_t last = std::min(step, output_.mean_stop - 1);
  return step == 0 || last < output_.mean_start ? 0 : 1 + (last - output_.mean_start) / output_.mean_every_steps;
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

FieldBlock read_flow(const FluidSetup& setup, const Box& box, SolverContext& context) try {
  Hdf5File file(setup.initial_flow.file, Hdf5File::Access::read, context);
  const std::string group = group_in(file, setup.initial_flow);
  const LatticeUnits units(setup);
  const std::vector<double> velocity = read_array(file, group + "/velocity_m_per_s", true, setup, box);
  const std::vector<double> excess_density = read_excess_density(file, group, setup, box);
  FieldBlock block{.box = box, .density_kg_per_m3 = {}, .velocity_m_per_s = {}, .body = {}};
  for_each_cell(box, [&](const Cell& cell) {
    const std::int64_t row = (cell[2] - box.low[2]) * box.extent(1) + cell[1] - box.low[1];
    const auto i = static_cast<std::size_t>(row * box.extent(0) + cell[0] - box.low[0]);
    const Eigen::Vector3d u_m_per_s(velocity[3 * i], velocity[3 * i + 1], velocity[3 * i + 2]);
    const double speed_lu = units.velocity_lu(u_m_per_s).norm();
    if (!(speed_lu < largest_speed_lu) || !(std::abs(excess_density[i]) < 0.5))
      throw CaseError(fmt::format(
          "{} has a flow in cell ({}) that cannot be computed (speed {:.3g} cells per step, at most {}; density {:.3g} "
          "times the fluid's, 0.5 to 1.5). Correct the file, or use a smaller step.",
          setup.initial_flow.file, fmt::join(cell, ", "), speed_lu, largest_speed_lu, 1.0 + excess_density[i]));
    block.density_kg_per_m3.push_back(units.density_kg_per_m3(1.0 + excess_density[i]));
    for (const double component : u_m_per_s) block.velocity_m_per_s.push_back(component);
  });
  return block;
} catch (const Error& error) {
  throw CaseError(std::string("fluid.initial_flow: ") + error.what());
}

void check_flow_file(const FluidSetup& setup) {
  SolverContext context;
  Box layer = Domain(setup, LatticeUnits(setup)).box();
  for (std::int64_t z = 0, end = layer.high[2]; z < end; ++z) {
    layer.low[2] = z;
    layer.high[2] = z + 1;
    read_flow(setup, layer, context);
  }
}

}  // namespace copepod::fluid
