#include "checkpoint/population_file.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "checkpoint/state_digest.hpp"
#include "checkpoint/sync_file.hpp"
#include "communication/fluid_setup_packing.hpp"
#include "communication/packing.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "output/parallel_file.hpp"

namespace copepod::fluid {

namespace {

constexpr std::int64_t format_version = 1;
constexpr std::int64_t slab_bytes = std::int64_t{256}
                                    << 20;  ///< MPI counts bytes in an int: 2 GB are too many at once
const std::string root = "/";
const std::string populations_name = "/populations";
const std::string kinematics_name = "/kinematics";
const std::string density_name = "/mean_density_sum";
const std::string velocity_name = "/mean_velocity_sum";
const std::string body_name = "/mean_body";

using Extent = ParallelFile::Extent;

Extent extent_of(const Cell& cell) {
  return {static_cast<std::uint64_t>(cell[0]), static_cast<std::uint64_t>(cell[1]),
          static_cast<std::uint64_t>(cell[2])};
}

Extent with(Extent extent, std::int64_t last) {
  extent.push_back(static_cast<std::uint64_t>(last));
  return extent;
}

/// Calls transfer(start, count, offset into this rank's values) for slabs of whole x planes, as often on
/// every rank.
template <class Transfer>
void for_each_slab(Communicator& communicator, const Box& box, std::int64_t cell_bytes,
                   const Transfer& transfer) {
  const std::int64_t plane_cells = box.extent(1) * box.extent(2);
  const std::int64_t planes = std::max<std::int64_t>(1, slab_bytes / (plane_cells * cell_bytes));
  std::array<std::int64_t, 1> rounds = {(box.extent(0) + planes - 1) / planes};
  communicator.max_to_all(rounds);
  for (std::int64_t round = 0; round < rounds[0]; ++round) {
    const std::int64_t first = std::min(round * planes, box.extent(0));
    const std::int64_t count = std::min(planes, box.extent(0) - first);  // 0: others still have planes to go
    transfer(extent_of({box.low[0] + first, box.low[1], box.low[2]}),
             extent_of({count, box.extent(1), box.extent(2)}), static_cast<std::size_t>(first * plane_cells));
  }
}

template <class T>
void write_field(ParallelFile& file, Communicator& communicator, const std::string& dataset,
                 const Cell& cells, const Box& box, std::int64_t components, const T* values) {
  file.make_dataset<T>(dataset, with(extent_of(cells), components));
  for_each_slab(communicator, box, components * std::int64_t{sizeof(T)},
                [&](const Extent& start, const Extent& count, std::size_t offset) {
                  file.write(dataset, with(start, 0), with(count, components),
                             values + offset * static_cast<std::size_t>(components));
                });
}

template <class T>
void read_field(ParallelFile& file, Communicator& communicator, const std::string& dataset, const Box& box,
                std::int64_t components, T* values) {
  for_each_slab(communicator, box, components * std::int64_t{sizeof(T)},
                [&](const Extent& start, const Extent& count, std::size_t offset) {
                  file.read(dataset, with(start, 0), with(count, components),
                            values + offset * static_cast<std::size_t>(components));
                });
}

/// Columns of position, orientation, velocity and angular velocity, one row of 13 per body.
std::vector<double> rows_of(const Kinematics& kinematics) {
  std::vector<double> rows;
  for (Eigen::Index body = 0; body < kinematics.bodies(); ++body) {
    Eigen::Matrix<double, 13, 1> row;
    row << kinematics.position_m.col(body), kinematics.orientation_wxyz.col(body),
        kinematics.velocity_m_per_s.col(body), kinematics.angular_velocity_rad_per_s.col(body);
    rows.insert(rows.end(), row.begin(), row.end());
  }
  return rows;
}

void take_rows(const std::vector<double>& rows, Kinematics& kinematics) {
  const Eigen::Map<const Eigen::Matrix<double, 13, Eigen::Dynamic>> all(
      rows.data(), 13, static_cast<Eigen::Index>(rows.size() / 13));
  kinematics.position_m = all.middleRows<3>(0);
  kinematics.orientation_wxyz = all.middleRows<4>(3);
  kinematics.velocity_m_per_s = all.middleRows<3>(7);
  kinematics.angular_velocity_rad_per_s = all.middleRows<3>(10);
}

/// Checksum of everything in the file, the same on all ranks.
template <class T>
std::uint64_t checksum(Communicator& communicator, const PopulationHeader& header, const Box& box,
                       std::span<const T> populations, const FluidState& state) {
  std::uint64_t sum =
      digest_of_populations(header.cells, box, populations) + digest_of_mean(header.cells, state.mean);
  if (communicator.rank() == 0)
    sum += digest_of_kinematics(state.kinematics) + mix_bits(static_cast<std::uint64_t>(header.step));
  std::array<std::int64_t, 1> total = {static_cast<std::int64_t>(sum)};
  communicator.sum_to_all(total);
  return static_cast<std::uint64_t>(total[0]);
}

void write_attributes(ParallelFile& file, const PopulationHeader& header, const FluidState& state,
                      std::uint64_t sum) {
  file.write_attribute(root, "format_version", format_version);
  file.write_attribute(root, "case_digest", header.case_digest);
  file.write_attribute(root, "nx", header.cells[0]);
  file.write_attribute(root, "ny", header.cells[1]);
  file.write_attribute(root, "nz", header.cells[2]);
  file.write_attribute(root, "step", header.step);
  file.write_attribute(root, "kinematics_step", state.kinematics.step);
  file.write_attribute(root, "bodies", std::int64_t{state.kinematics.bodies()});
  file.write_attribute(root, "mean_samples", state.mean.samples());
  file.write_attribute(root, "checksum", sum);
}

void write_kinematics(ParallelFile& file, Communicator& communicator, const Kinematics& kinematics) {
  if (kinematics.bodies() == 0) return;
  const std::vector<double> rows = rows_of(kinematics);
  const auto bodies = static_cast<std::uint64_t>(kinematics.bodies());
  file.make_dataset<double>(kinematics_name, {bodies, 13});
  file.write(kinematics_name, {0, 0}, {communicator.rank() == 0 ? bodies : 0, 13}, rows.data());
}

void write_mean(ParallelFile& file, Communicator& communicator, const Cell& cells, const MeanField& mean) {
  if (mean.samples() == 0) return;
  const FieldBlock& sums = mean.sums();
  write_field(file, communicator, density_name, cells, sums.box, 1, sums.density_kg_per_m3.data());
  write_field(file, communicator, velocity_name, cells, sums.box, 3, sums.velocity_m_per_s.data());
  write_field(file, communicator, body_name, cells, sums.box, 1, sums.body.data());
}

void read_kinematics(ParallelFile& file, Kinematics& kinematics) {
  const auto bodies = static_cast<std::uint64_t>(file.read_attribute<std::int64_t>(root, "bodies"));
  std::vector<double> rows(13 * bodies);
  if (bodies > 0) file.read(kinematics_name, {0, 0}, {bodies, 13}, rows.data());
  take_rows(rows, kinematics);
  kinematics.step = file.read_attribute<std::int64_t>(root, "kinematics_step");
}

void read_mean(ParallelFile& file, Communicator& communicator, const Box& box, MeanField& mean) {
  const auto samples = file.read_attribute<std::int64_t>(root, "mean_samples");
  FieldBlock sums;
  if (samples > 0) {
    const auto cells = static_cast<std::size_t>(box.volume());
    sums.box = box;
    sums.density_kg_per_m3.resize(cells);
    sums.velocity_m_per_s.resize(3 * cells);
    sums.body.resize(cells);
    read_field(file, communicator, density_name, box, 1, sums.density_kg_per_m3.data());
    read_field(file, communicator, velocity_name, box, 3, sums.velocity_m_per_s.data());
    read_field(file, communicator, body_name, box, 1, sums.body.data());
  }
  mean.restore(samples, std::move(sums));
}

std::string size_text(const Cell& cells) {
  return std::to_string(cells[0]) + "×" + std::to_string(cells[1]) + "×" + std::to_string(cells[2]);
}

/// Reads the header and refuses the checkpoint of another case; same verdict on all ranks.
PopulationHeader read_header(ParallelFile& file, const std::string& path, const PopulationHeader& expected) {
  if (const auto version = file.read_attribute<std::int64_t>(root, "format_version");
      version != format_version)
    throw StorageError(path + " has checkpoint format " + std::to_string(version) + " (this version reads " +
                       std::to_string(format_version) + "). Resume with the version that wrote it.");
  PopulationHeader header;
  header.cells = {file.read_attribute<std::int64_t>(root, "nx"),
                  file.read_attribute<std::int64_t>(root, "ny"),
                  file.read_attribute<std::int64_t>(root, "nz")};
  header.case_digest = file.read_attribute<std::uint64_t>(root, "case_digest");
  header.step = file.read_attribute<std::int64_t>(root, "step");
  if (header.cells != expected.cells)
    throw StorageError(path + " holds " + size_text(header.cells) + " cells (the case has " +
                       size_text(expected.cells) + "). Resume with the case that wrote it.");
  if (header.case_digest != expected.case_digest)
    throw StorageError(
        path + " is of another case (its fluid settings differ). Resume with the case that wrote it.");
  return header;
}

}  // namespace

std::uint64_t digest_of(const FluidSetup& setup) {
  std::vector<std::byte> bytes;
  Packer packer(bytes);
  describe_physics(packer, setup);
  Digest digest;
  for (const std::byte byte : bytes) digest.add(std::uint64_t{std::to_integer<unsigned char>(byte)});
  return digest.value();
}

template <class T>
void save_populations(const std::string& path, Communicator& communicator, const PopulationHeader& header,
                      const Box& box, std::span<const T> populations, const FluidState& state) {
  const std::string unfinished = path + ".tmp";
  const std::uint64_t sum = checksum(communicator, header, box, populations, state);
  ParallelFile file(unfinished, ParallelFile::Access::create, communicator);
  write_attributes(file, header, state, sum);
  write_field(file, communicator, populations_name, header.cells, box, 19, populations.data());
  write_kinematics(file, communicator, state.kinematics);
  write_mean(file, communicator, header.cells, state.mean);
  file.close();
  file.on_leader([&] { publish(unfinished, path); });
}

template <class T>
PopulationHeader restore_populations(const std::string& path, Communicator& communicator,
                                     const PopulationHeader& expected, const Box& box,
                                     std::span<T> populations, FluidState& state) {
  ParallelFile file(path, ParallelFile::Access::read, communicator);
  const PopulationHeader header = read_header(file, path, expected);
  read_field(file, communicator, populations_name, box, 19, populations.data());
  read_kinematics(file, state.kinematics);
  read_mean(file, communicator, box, state.mean);
  const auto written = file.read_attribute<std::uint64_t>(root, "checksum");
  file.close();
  if (checksum<T>(communicator, header, box, populations, state) != written)
    throw StorageError(path +
                       " is damaged (its checksum does not match its contents). Use an earlier checkpoint.");
  return header;
}

template void save_populations(const std::string&, Communicator&, const PopulationHeader&, const Box&,
                               std::span<const float>, const FluidState&);
template void save_populations(const std::string&, Communicator&, const PopulationHeader&, const Box&,
                               std::span<const double>, const FluidState&);
template PopulationHeader restore_populations(const std::string&, Communicator&, const PopulationHeader&,
                                              const Box&, std::span<float>, FluidState&);
template PopulationHeader restore_populations(const std::string&, Communicator&, const PopulationHeader&,
                                              const Box&, std::span<double>, FluidState&);

}  // namespace copepod::fluid
