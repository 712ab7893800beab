#include "lattice_boltzmann/output/population_file.hpp"

#include <array>
#include <vector>

#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "files/hdf5_file.hpp"
#include "system/durable_file.hpp"

namespace copepod::fluid {

namespace {

constexpr std::int64_t format_version = 6;
constexpr std::int64_t layout_bytes = 1 << 16;  ///< more than HDF5 needs to describe the datasets
constexpr std::int64_t piece_bytes = 1 << 18;   ///< of populations at once: stays in a core's cache
const std::string root = "/";
const std::string populations_name = "/populations";
const std::string bodies_name = "/bodies";
const std::string density_name = "/mean_density_sum";
const std::string velocity_name = "/mean_velocity_sum";
const std::string body_name = "/mean_body";
const std::array<std::string, 3> momentum_gained = {"momentum_gained_x", "momentum_gained_y", "momentum_gained_z"};

using Extent = Hdf5File::Extent;

Extent extent_of(const Cell& cell) { return {cell.begin(), cell.end()}; }

Extent count_of(const Box& box) { return extent_of({box.extent(0), box.extent(1), box.extent(2)}); }

/// Per body: position, orientation, velocity, angular velocity, absorbed mass.
constexpr Eigen::Index columns = 15;
using Rows = Eigen::Matrix<double, columns, Eigen::Dynamic>;

Rows rows_of(const FluidState& state) {
  Rows rows(columns, state.kinematics.bodies());
  if (rows.cols() == 0) return rows;
  rows << state.kinematics.position_m, state.kinematics.orientation_wxyz, state.kinematics.velocity_m_per_s,
      state.kinematics.angular_velocity_rad_per_s, state.absorbed_mass;
  return rows;
}

void take_rows(const Rows& rows, FluidState& state) {
  state.kinematics.resize(rows.cols());
  state.absorbed_mass.resize(2, rows.cols());
  if (rows.cols() == 0) return;
  state.kinematics.position_m = rows.middleRows<3>(0);
  state.kinematics.orientation_wxyz = rows.middleRows<4>(3);
  state.kinematics.velocity_m_per_s = rows.middleRows<3>(7);
  state.kinematics.angular_velocity_rad_per_s = rows.middleRows<3>(10);
  state.absorbed_mass = rows.middleRows<2>(13);
}

/// visit(piece, populations) for the pieces of a rank's block, with room for the populations of one.
template <class T, class Visit>
void for_each_piece_of_populations(const Box& box, const Visit& visit) {
  std::vector<T> populations;
  for_each_piece(box, piece_bytes / (19 * std::int64_t{sizeof(T)}), [&](const Box& piece) {
    populations.resize(19 * piece.volume());
    visit(piece, std::span<T>(populations));
  });
}

/// Sum of the digests of all cells of `box`. Shows progress.
template <class T>
std::uint64_t digest_of_populations(const Cell& cells, const Box& box, std::span<const T> populations,
                                    SolverContext& context) {
  std::uint64_t sum = 0;
  auto next = populations.begin();
  const auto add = [&](const Cell& cell) { sum += digest_of_cell(cells, cell, [&](int) { return *next++; }); };
  for_each_cell(box, add, [&] { context.report_progress(); });
  return sum;
}

/// The same for the sums of a mean field; 0 without samples.
std::uint64_t digest_of_mean(const Cell& cells, const MeanField& mean, SolverContext& context) {
  if (mean.samples() == 0) return 0;
  const FieldBlock& sums = mean.sums();
  const auto samples = static_cast<std::uint64_t>(mean.samples());
  std::uint64_t sum = 0;
  std::size_t i = 0;
  const auto add = [&](const Cell& cell) {
    Digest digest(static_cast<std::uint64_t>((cell[0] * cells[1] + cell[1]) * cells[2] + cell[2]));
    digest.add(samples);
    digest.add(sums.density_kg_per_m3[i]);
    for (std::size_t axis = 0; axis < 3; ++axis) digest.add(sums.velocity_m_per_s[3 * i + axis]);
    digest.add(static_cast<std::uint64_t>(sums.body[i]));
    sum += digest.value();
    ++i;
  };
  for_each_cell(sums.box, add, [&] { context.report_progress(); });
  return sum;
}

std::uint64_t digest_of_bodies(const FluidState& state) {
  Digest digest(static_cast<std::uint64_t>(state.kinematics.step));
  digest.add_all(rows_of(state));
  digest.add_all(state.momentum.gained);
  digest.add(state.momentum.exchanged);
  return digest.value();
}

/// Checksum of everything in the file, the same on all ranks.
/// @param populations  digest of this rank's
std::uint64_t checksum(Communicator& communicator, const PopulationHeader& header, std::uint64_t populations,
                       const FluidState& state) {
  std::uint64_t sum = populations + digest_of_mean(header.cells, state.mean, communicator.context());
  if (communicator.rank() == 0) sum += digest_of_bodies(state) + mix_bits(static_cast<std::uint64_t>(header.step));
  std::array<std::int64_t, 1> total = {static_cast<std::int64_t>(sum)};
  communicator.sum_to_all(total);
  return static_cast<std::uint64_t>(total[0]);
}

/// Where the datasets start in the file [bytes].
struct Offsets {
  std::int64_t populations = 0;
  std::int64_t bodies = 0;
  std::int64_t density = 0;
  std::int64_t velocity = 0;
  std::int64_t body = 0;
};

/// Makes the file with everything but the values of its datasets, and takes the disk space.
template <class T>
Offsets lay_out(const std::string& path, const PopulationHeader& header, const FluidState& state, std::uint64_t sum,
                SolverContext& context) {
  const std::int64_t mean_bytes = state.mean.samples() > 0 ? 4 * sizeof(double) + sizeof(std::int32_t) : 0;
  const std::int64_t cell_bytes = 19 * std::int64_t{sizeof(T)} + mean_bytes;
  require_space(path,
                header.cells[0] * header.cells[1] * header.cells[2] * cell_bytes + layout_bytes +
                    state.kinematics.bodies() * columns * std::int64_t{sizeof(double)},
                context);
  Hdf5File file(path, Hdf5File::Access::create, context);
  file.write_attribute(root, "format_version", format_version);
  file.write_attribute(root, "layout_digest", header.layout_digest);
  file.write_attribute(root, "nx", header.cells[0]);
  file.write_attribute(root, "ny", header.cells[1]);
  file.write_attribute(root, "nz", header.cells[2]);
  file.write_attribute(root, "step", header.step);
  file.write_attribute(root, "kinematics_step", state.kinematics.step);
  file.write_attribute(root, "bodies", std::int64_t{state.kinematics.bodies()});
  file.write_attribute(root, "mean_samples", state.mean.samples());
  file.write_attribute(root, "mean_start", state.sampling.start);
  file.write_attribute(root, "mean_every_steps", state.sampling.every_steps);
  for (std::size_t axis = 0; axis < 3; ++axis)
    file.write_attribute(root, momentum_gained[axis], state.momentum.gained[axis]);
  file.write_attribute(root, "momentum_exchanged", state.momentum.exchanged);
  file.write_attribute(root, "checksum", sum);
  const Extent shape = extent_of(header.cells);
  Offsets offsets;
  offsets.populations = file.make_dataset<T>(populations_name, Hdf5File::with(shape, 19));
  if (state.kinematics.bodies() > 0)
    offsets.bodies =
        file.make_dataset<double>(bodies_name, {static_cast<std::uint64_t>(state.kinematics.bodies()), columns});
  if (state.mean.samples() > 0) {
    offsets.density = file.make_dataset<double>(density_name, shape);
    offsets.velocity = file.make_dataset<double>(velocity_name, Hdf5File::with(shape, 3));
    offsets.body = file.make_dataset<std::int32_t>(body_name, shape);
  }
  file.close();
  reserve_space(path, context);
  return offsets;
}

template <class T>
void write_populations(SharedFile& file, std::int64_t offset, const Cell& cells, const Box& box,
                       const GetPopulations<T>& get) {
  for_each_piece_of_populations<T>(box, [&](const Box& piece, std::span<T> populations) {
    get(piece, populations);
    file.write(offset, Hdf5File::with(extent_of(cells), 19), Hdf5File::with(extent_of(piece.low), 0),
               Hdf5File::with(count_of(piece), 19), populations.data());
  });
}

void write_mean(SharedFile& file, const Offsets& offsets, const Cell& cells, const FieldBlock& sums) {
  const Extent shape = extent_of(cells);
  const Extent start = extent_of(sums.box.low);
  const Extent count = count_of(sums.box);
  file.write(offsets.density, shape, start, count, sums.density_kg_per_m3.data());
  file.write(offsets.velocity, Hdf5File::with(shape, 3), Hdf5File::with(start, 0), Hdf5File::with(count, 3),
             sums.velocity_m_per_s.data());
  file.write(offsets.body, shape, start, count, sums.body.data());
}

void write_bodies(const std::string& path, const Offsets& offsets, const FluidState& state, SolverContext& context) {
  const Extent shape = {static_cast<std::uint64_t>(state.kinematics.bodies()), columns};
  const Rows rows = rows_of(state);
  SharedFile(path, context).write(offsets.bodies, shape, {0, 0}, shape, rows.data());
}

void read_bodies(Hdf5File& file, FluidState& state) {
  Rows rows(columns, file.read_attribute<std::int64_t>(root, "bodies"));
  if (rows.cols() > 0) file.read(bodies_name, {0, 0}, {static_cast<std::uint64_t>(rows.cols()), columns}, rows.data());
  take_rows(rows, state);
  state.kinematics.step = file.read_attribute<std::int64_t>(root, "kinematics_step");
}

void read_momentum(Hdf5File& file, MomentumBalance& momentum) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    momentum.gained[axis] = file.read_attribute<double>(root, momentum_gained[axis]);
  momentum.exchanged = file.read_attribute<double>(root, "momentum_exchanged");
}

/// @return digest of this rank's populations
template <class T>
std::uint64_t read_populations(Hdf5File& file, const PopulationHeader& header, const Box& box,
                               const TakePopulations<T>& take, SolverContext& context) {
  std::uint64_t digest = 0;
  for_each_piece_of_populations<T>(box, [&](const Box& piece, std::span<T> populations) {
    file.read(populations_name, Hdf5File::with(extent_of(piece.low), 0), Hdf5File::with(count_of(piece), 19),
              populations.data());
    digest += digest_of_populations<T>(header.cells, piece, populations, context);
    take(header, piece, populations);
  });
  return digest;
}

void read_mean(Hdf5File& file, const Box& box, FluidState& state) {
  const auto samples = file.read_attribute<std::int64_t>(root, "mean_samples");
  FieldBlock sums;
  if (samples > 0) {
    const auto cells = static_cast<std::size_t>(box.volume());
    const Extent start = extent_of(box.low);
    const Extent count = count_of(box);
    sums.box = box;
    sums.density_kg_per_m3.resize(cells);
    sums.velocity_m_per_s.resize(3 * cells);
    sums.body.resize(cells);
    file.read(density_name, start, count, sums.density_kg_per_m3.data());
    file.read(velocity_name, Hdf5File::with(start, 0), Hdf5File::with(count, 3), sums.velocity_m_per_s.data());
    file.read(body_name, start, count, sums.body.data());
  }
  state.mean.restore(samples, std::move(sums));
  state.sampling = {file.read_attribute<std::int64_t>(root, "mean_start"),
                    file.read_attribute<std::int64_t>(root, "mean_every_steps")};
}

std::string size_text(const Cell& cells) {
  return std::to_string(cells[0]) + "×" + std::to_string(cells[1]) + "×" + std::to_string(cells[2]);
}

/// Reads the header and refuses the checkpoint of another case.
PopulationHeader read_header(Hdf5File& file, const std::string& path, const PopulationHeader& expected) {
  if (const auto version = file.read_attribute<std::int64_t>(root, "format_version"); version != format_version)
    throw StorageError(path + " has checkpoint format " + std::to_string(version) + " (this version reads " +
                       std::to_string(format_version) + "). Resume with the version that wrote it.");
  PopulationHeader header;
  header.cells = {file.read_attribute<std::int64_t>(root, "nx"), file.read_attribute<std::int64_t>(root, "ny"),
                  file.read_attribute<std::int64_t>(root, "nz")};
  header.layout_digest = file.read_attribute<std::uint64_t>(root, "layout_digest");
  header.step = file.read_attribute<std::int64_t>(root, "step");
  if (header.cells != expected.cells)
    throw StorageError(path + " holds " + size_text(header.cells) + " cells (the case has " +
                       size_text(expected.cells) + "). Resume with the case that wrote it.");
  if (header.layout_digest != expected.layout_digest)
    throw StorageError(
        path +
        " is of another case (its cells, step, precision or bodies differ). Resume with the case that wrote it.");
  return header;
}

}  // namespace

std::uint64_t layout_digest(const FluidSetup& setup) {
  FluidSetup layout;
  layout.step_s = setup.step_s;
  layout.cell_size_m = setup.cell_size_m;
  layout.domain_cells = setup.domain_cells;
  layout.symmetry_planes = setup.symmetry_planes;
  layout.precision = setup.precision;
  layout.bodies = setup.bodies;
  return copepod::digest_of(conversion::to_bytes(layout));
}

template <class T>
void save_populations(const std::string& path, Communicator& communicator, const PopulationHeader& header,
                      const Box& box, const GetPopulations<T>& get, const FluidState& state) {
  const std::string unfinished = path + ".tmp";
  std::uint64_t digest = 0;
  for_each_piece_of_populations<T>(box, [&](const Box& piece, std::span<T> populations) {
    get(piece, populations);
    digest += digest_of_populations<T>(header.cells, piece, populations, communicator.context());
  });
  const std::uint64_t sum = checksum(communicator, header, digest, state);
  Offsets offsets;
  on_leader(communicator, [&] {
    offsets = lay_out<T>(unfinished, header, state, sum, communicator.context());
    if (state.kinematics.bodies() > 0) write_bodies(unfinished, offsets, state, communicator.context());
  });
  communicator.broadcast(std::as_writable_bytes(std::span(&offsets, 1)));
  on_every_rank(communicator, [&] {
    SharedFile file(unfinished, communicator.context());
    write_populations<T>(file, offsets.populations, header.cells, box, get);
    if (state.mean.samples() > 0) write_mean(file, offsets, header.cells, state.mean.sums());
    file.sync();
  });
  on_leader(communicator, [&] { publish(unfinished, path); });
}

template <class T>
PopulationHeader restore_populations(const std::string& path, Communicator& communicator,
                                     const PopulationHeader& expected, const Box& box, const TakePopulations<T>& take,
                                     FluidState& state) {
  PopulationHeader header;
  std::uint64_t digest = 0;
  std::uint64_t written = 0;
  on_every_rank(communicator, [&] {
    Hdf5File file(path, Hdf5File::Access::read, communicator.context());
    header = read_header(file, path, expected);
    digest = read_populations<T>(file, header, box, take, communicator.context());
    read_bodies(file, state);
    read_momentum(file, state.momentum);
    read_mean(file, box, state);
    written = file.read_attribute<std::uint64_t>(root, "checksum");
  });
  if (checksum(communicator, header, digest, state) != written)
    throw StorageError(path + " is damaged (its checksum does not match its contents). Use an earlier checkpoint.");
  return header;
}

template void save_populations(const std::string&, Communicator&, const PopulationHeader&, const Box&,
                               const GetPopulations<float>&, const FluidState&);
template void save_populations(const std::string&, Communicator&, const PopulationHeader&, const Box&,
                               const GetPopulations<double>&, const FluidState&);
template PopulationHeader restore_populations(const std::string&, Communicator&, const PopulationHeader&, const Box&,
                                              const TakePopulations<float>&, FluidState&);
template PopulationHeader restore_populations(const std::string&, Communicator&, const PopulationHeader&, const Box&,
                                              const TakePopulations<double>&, FluidState&);

}  // namespace copepod::fluid
