#include "output/field_writer.hpp"

#include <array>
#include <filesystem>

#include "output/parallel_file.hpp"
#include "output/xdmf.hpp"

namespace copepod::fluid {

namespace {

const std::string data_file = "fields.h5";
const std::string description_file = "fields.xdmf";

ParallelFile::Extent in_file_order(const Cell& cell) {
  return {static_cast<std::uint64_t>(cell[2]), static_cast<std::uint64_t>(cell[1]),
          static_cast<std::uint64_t>(cell[0])};
}

ParallelFile::Extent with(ParallelFile::Extent extent, std::uint64_t last) {
  extent.push_back(last);
  return extent;
}

}  // namespace

FieldWriter::FieldWriter(const FieldOutput& output, const FluidSetup& setup, Communicator& communicator)
    : output_(output),
      step_s_(setup.step_s),
      cell_size_m_(setup.cell_size_m),
      images_(setup.domain_cells, setup.symmetry_planes),
      communicator_(communicator) {}

ParallelFile FieldWriter::begin_group(const std::string& group) const {
  const std::string path = output_.directory + "/" + data_file;
  // Rank 0 decides for all: on a network file system the others may see the file later.
  std::array<std::int64_t, 1> exists = {communicator_.rank() == 0 && std::filesystem::exists(path) ? 1 : 0};
  communicator_.max_to_all(exists);
  ParallelFile file(path, exists[0] != 0 ? ParallelFile::Access::extend : ParallelFile::Access::create,
                    communicator_);
  file.make_group(group);
  file.write_attribute(group, "cell_size_m", cell_size_m_);
  file.write_attribute(group, "step_s", step_s_);
  return file;
}

void FieldWriter::write_fields(ParallelFile& file, const std::string& group, const FieldBlock& block) const {
  const ParallelFile::Extent shape = in_file_order(images_.domain_cells());
  const std::string density = group + "/density_kg_per_m3";
  const std::string velocity = group + "/velocity_m_per_s";
  const std::string body = group + "/body";
  file.make_dataset<double>(density, shape);
  file.make_dataset<double>(velocity, with(shape, 3));
  file.make_dataset<std::int32_t>(body, shape);
  for (const auto& mirrored : images_.images()) {
    const FileBlock image = images_.image(block, mirrored);
    const ParallelFile::Extent start = in_file_order(image.box.low);
    const ParallelFile::Extent count =
        in_file_order({image.box.extent(0), image.box.extent(1), image.box.extent(2)});
    file.write(density, start, count, image.density_kg_per_m3.data());
    file.write(velocity, with(start, 0), with(count, 3), image.velocity_m_per_s.data());
    file.write(body, start, count, image.body.data());
  }
}

void FieldWriter::finish(ParallelFile& file) const {
  XdmfDescription description;
  description.cells = images_.domain_cells();
  description.cell_size_m = cell_size_m_;
  description.step_s = step_s_;
  description.data_file = data_file;
  description.groups = file.groups();
  file.close();
  file.on_leader([&] { replace_file(output_.directory + "/" + description_file, xdmf_text(description)); });
}

void FieldWriter::write_snapshot(std::int64_t step, const FieldBlock& block) {
  const std::string group = group_of_step(step);
  ParallelFile file = begin_group(group);
  file.write_attribute(group, "step", step);
  file.write_attribute(group, "time_s", static_cast<double>(step) * step_s_);
  write_fields(file, group, block);
  finish(file);
}

void FieldWriter::write_mean(std::int64_t samples, const FieldBlock& block) {
  const std::string group = "mean";
  ParallelFile file = begin_group(group);
  file.write_attribute(group, "samples", samples);
  file.write_attribute(group, "mean_start", output_.mean_start);
  file.write_attribute(group, "mean_stop", output_.mean_stop);
  file.write_attribute(group, "mean_every_steps", output_.mean_every_steps);
  write_fields(file, group, block);
  finish(file);
}

}  // namespace copepod::fluid
