#include "lattice_boltzmann/output/fields.hpp"

#include <cstdlib>
#include <iomanip>
#include <limits>
#include <map>
#include <span>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace copepod::fluid {

namespace {

void add_to(std::vector<double>& sums, const std::vector<double>& values) {
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += values[i];
}

const std::string snapshot_prefix = "step_";

/// Three numbers in file order: z, y, x.
std::string in_words(const Cell& cell) {
  return std::to_string(cell[2]) + " " + std::to_string(cell[1]) + " " + std::to_string(cell[0]);
}

void add_grid(std::ostream& text, double cell_size_m, double step_s, const XdmfGrid& grid, const std::string& indent) {
  const Cell cells = {grid.box.extent(0), grid.box.extent(1), grid.box.extent(2)};
  const auto origin_m = [&](int axis) { return static_cast<double>(grid.box.low[axis]) * cell_size_m; };
  text << indent << "<Grid Name='" << grid.group << "' GridType='Uniform'>\n";
  if (const std::int64_t step = step_of_group(grid.group); step >= 0)
    text << indent << "  <Time Value='" << static_cast<double>(step) * step_s << "'/>\n";
  text << indent << "  <Topology TopologyType='3DCoRectMesh' Dimensions='"
       << in_words({cells[0] + 1, cells[1] + 1, cells[2] + 1}) << "'/>\n"
       << indent << "  <Geometry GeometryType='ORIGIN_DXDYDZ'>\n"
       << indent << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>" << origin_m(2) << " "
       << origin_m(1) << " " << origin_m(0) << "</DataItem>\n"
       << indent << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>" << cell_size_m << " "
       << cell_size_m << " " << cell_size_m << "</DataItem>\n"
       << indent << "  </Geometry>\n";
  for (const FieldArray& array : field_arrays) {
    if (std::ranges::find(grid.datasets, array.name) == grid.datasets.end()) continue;
    text << indent << "  <Attribute Name='" << array.name << "' AttributeType='"
         << (array.is_vector() ? "Vector" : "Scalar") << "' Center='Cell'>\n"
         << indent << "    <DataItem Dimensions='" << in_words(cells) << (array.is_vector() ? " 3" : "")
         << (array.quantity ? "' NumberType='Float' Precision='8'" : "' NumberType='Int' Precision='4'")
         << " Format='HDF'>" << grid.file << ":/" << grid.group << "/" << array.name << "</DataItem>\n"
         << indent << "  </Attribute>\n";
  }
  text << indent << "</Grid>\n";
}

}  // namespace

void MeanField::add(const FieldBlock& block) {
  if (samples_++ == 0) {
    sums_ = block;
    return;
  }
  if (sums_.box != block.box) throw std::logic_error("samples of one mean cover different cells");
  add_to(sums_.density_kg_per_m3, block.density_kg_per_m3);
  add_to(sums_.velocity_m_per_s, block.velocity_m_per_s);
  sums_.body = block.body;
}

FieldBlock MeanField::mean() const {
  FieldBlock mean = sums_;
  const auto samples = static_cast<double>(samples_);
  for (double& value : mean.density_kg_per_m3) value /= samples;
  for (double& value : mean.velocity_m_per_s) value /= samples;
  return mean;
}

void MeanField::restore(std::int64_t samples, FieldBlock sums) {
  samples_ = samples;
  sums_ = std::move(sums);
}

std::vector<std::array<bool, 3>> MirrorImages::images() const {
  std::vector<std::array<bool, 3>> images;
  for (int bits = 0; bits < 8; ++bits) {
    const std::array<bool, 3> mirrored = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
    bool exists = true;
    for (int axis = 0; axis < 3; ++axis) exists = exists && (!mirrored[axis] || symmetric_[axis]);
    if (exists) images.push_back(mirrored);
  }
  return images;
}

VelocityGradient::VelocityGradient(const FluidSetup& setup, const FieldBlock& block, Communicator& communicator)
    : unit_(setup.cell_size_m / setup.step_s),
      domain_(setup, LatticeUnits(setup)),
      partition_(domain_.cells(), communicator.size(), setup.bodies.size()),
      layout_(block.box, sizeof(double)),
      stride_{layout_.neighbour(1), layout_.neighbour(3), layout_.neighbour(5)} {
  for (std::vector<double>& component : u_) component.resize(layout_.cells());
  auto next = block.velocity_m_per_s.begin();
  for_each_cell(block.box, [&](const Cell& cell) {
    for (std::vector<double>& component : u_) component[layout_.cell(cell)] = *next++;
  });
  fill_ghosts(communicator);
}

/// Rank that holds the cells beyond a face of the block; −1: none does.
int VelocityGradient::rank_beyond(int axis, bool high) const {
  Cell cell = layer(axis, high, true).low;
  const auto index = domain_.image(axis, cell[axis]);
  if (!index) return -1;
  cell[axis] = *index;
  return partition_.owner(cell);
}

Box VelocityGradient::layer(int axis, bool high, bool beyond) const {
  Box layer = layout_.block();
  const std::int64_t out = beyond ? 1 : 0;
  layer.low[axis] = high ? layer.high[axis] - 1 + out : layer.low[axis] - out;
  layer.high[axis] = layer.low[axis] + 1;
  return layer;
}

/// Beyond a face whose other side is this rank's, a wall, or open.
void VelocityGradient::fill_locally(int axis, bool high) {
  const Face& face = domain_.face(axis, high);
  const bool one_sided = face.is_open() || face.is_parabolic || face.signal || !face.profile.empty();
  const std::int64_t inwards = high ? -stride_[axis] : stride_[axis];
  const Box ghosts = layer(axis, high, true);
  const auto index = domain_.image(axis, ghosts.low[axis]);
  for_each_cell(ghosts, [&](Cell cell) {
    const std::int64_t ghost = layout_.cell(cell), inside = ghost + inwards;
    cell[axis] = index.value_or(cell[axis]);
    for (int i = 0; i < 3; ++i) {
      std::vector<double>& u = u_[i];
      if (index)
        u[ghost] = face.kind == FaceKind::mirror && i == axis ? -u[inside] : u[layout_.cell(cell)];
      else if (one_sided)
        u[ghost] = domain_.cells()[axis] > 1 ? 2.0 * u[inside] - u[inside + inwards] : u[inside];
      else
        u[ghost] = 2.0 * unit_ * face.velocity_lu[i] - u[inside];
    }
  });
}

/// Two ranks that share several faces, like the two halves of a periodic domain, exchange one message: layers in the
/// order of the receiver's faces.
void VelocityGradient::fill_ghosts(Communicator& communicator) {
  struct Buffers {
    std::vector<double> send, receive;
    std::vector<std::size_t> faces;  ///< whose layers are received
  };
  std::map<int, Buffers> peers;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) {
      const int sender = rank_beyond(axis, high), own = communicator.rank();
      if (sender >= 0 && sender != own) peers[sender].faces.push_back(face_index(axis, high));
      // The face of the receiver opposite to this one is the same place.
      const int receiver = rank_beyond(axis, !high);
      if (receiver < 0 || receiver == own) continue;
      for_each_cell(layer(axis, !high, false), [&](const Cell& cell) {
        for (const std::vector<double>& u : u_) peers[receiver].send.push_back(u[layout_.cell(cell)]);
      });
    }
  std::vector<Communicator::Message> messages;
  for (auto& [rank, buffers] : peers) {
    buffers.receive.resize(buffers.send.size());
    messages.push_back(
        {rank, std::as_bytes(std::span(buffers.send)), std::as_writable_bytes(std::span(buffers.receive))});
  }
  communicator.start_exchange(messages)();
  for (const auto& [rank, buffers] : peers) {
    auto next = buffers.receive.begin();
    for (const std::size_t face : buffers.faces)
      for_each_cell(layer(static_cast<int>(face / 2), face % 2 == 1, true), [&](const Cell& cell) {
        for (std::vector<double>& u : u_) u[layout_.cell(cell)] = *next++;
      });
  }
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true})
      if (const int rank = rank_beyond(axis, high); rank < 0 || rank == communicator.rank()) fill_locally(axis, high);
}

std::vector<double> vorticity(const FluidSetup& setup, const FieldBlock& block, Communicator& communicator) {
  const VelocityGradient gradient(setup, block, communicator);
  std::vector<double> result;
  result.reserve(block.velocity_m_per_s.size());
  for_each_cell(block.box, [&](const Cell& cell) {
    const bool is_fluid = block.body[result.size() / 3] == 0;
    const Eigen::Matrix3d g = gradient(cell);
    for (const auto& [i, j] : {std::pair{2, 1}, std::pair{0, 2}, std::pair{1, 0}})
      result.push_back(is_fluid ? (g(i, j) - g(j, i)) / setup.cell_size_m : 0.0);
  });
  return result;
}

std::int64_t step_of_group(const std::string& group) {
  if (!group.starts_with(snapshot_prefix)) return -1;
  return std::strtoll(group.c_str() + snapshot_prefix.size(), nullptr, 10);
}

std::string group_of_step(std::int64_t step) {
  std::ostringstream name;
  name << snapshot_prefix << std::setw(9) << std::setfill('0') << step;
  return name.str();
}

std::string xdmf_text(double cell_size_m, double step_s, const std::vector<XdmfGrid>& grids) {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10);
  text << "<?xml version='1.0' encoding='utf-8'?>\n<Xdmf Version='2.0'>\n  <Domain>\n";
  const bool has_times = !grids.empty() && step_of_group(grids.front().group) >= 0;
  if (has_times) text << "    <Grid Name='snapshots' GridType='Collection' CollectionType='Temporal'>\n";
  for (const XdmfGrid& grid : grids) add_grid(text, cell_size_m, step_s, grid, has_times ? "      " : "    ");
  if (has_times) text << "    </Grid>\n";
  text << "  </Domain>\n</Xdmf>\n";
  return text.str();
}

}  // namespace copepod::fluid
