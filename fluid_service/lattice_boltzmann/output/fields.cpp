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

std::size_t index_in(const Box& block, const Cell& cell) {
  return static_cast<std::size_t>(
      ((cell[0] - block.low[0]) * block.extent(1) + cell[1] - block.low[1]) * block.extent(2) + cell[2] - block.low[2]);
}

/// The layer of cells `at` along an axis, of the same cross section as the block.
Box layer_of(Box block, int axis, std::int64_t at) {
  block.low[axis] = at;
  block.high[axis] = at + 1;
  return block;
}

std::vector<double> velocities_in(const FieldBlock& block, const Box& layer) {
  std::vector<double> velocities;
  velocities.reserve(3 * static_cast<std::size_t>(layer.volume()));
  for_each_cell(layer, [&](const Cell& cell) {
    const double* velocity = &block.velocity_m_per_s[3 * index_in(block.box, cell)];
    velocities.insert(velocities.end(), velocity, velocity + 3);
  });
  return velocities;
}

std::int64_t edge(const Box& block, int axis, bool high) { return high ? block.high[axis] - 1 : block.low[axis]; }

const std::string snapshot_prefix = "step_";

/// Three numbers in file order: z, y, x.
std::string in_words(const Cell& cell) {
  return std::to_string(cell[2]) + " " + std::to_string(cell[1]) + " " + std::to_string(cell[0]);
}

void add_grid(std::ostream& text, const XdmfDescription& d, const XdmfGrid& grid, const std::string& indent) {
  const Cell cells = {grid.box.extent(0), grid.box.extent(1), grid.box.extent(2)};
  const auto origin_m = [&](int axis) { return static_cast<double>(grid.box.low[axis]) * d.cell_size_m; };
  text << indent << "<Grid Name='" << grid.group << "' GridType='Uniform'>\n";
  if (const std::int64_t step = step_of_group(grid.group); step >= 0)
    text << indent << "  <Time Value='" << static_cast<double>(step) * d.step_s << "'/>\n";
  text << indent << "  <Topology TopologyType='3DCoRectMesh' Dimensions='"
       << in_words({cells[0] + 1, cells[1] + 1, cells[2] + 1}) << "'/>\n"
       << indent << "  <Geometry GeometryType='ORIGIN_DXDYDZ'>\n"
       << indent << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>" << origin_m(2) << " "
       << origin_m(1) << " " << origin_m(0) << "</DataItem>\n"
       << indent << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>" << d.cell_size_m
       << " " << d.cell_size_m << " " << d.cell_size_m << "</DataItem>\n"
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

Vorticity::Vorticity(const FluidSetup& setup, Communicator& communicator)
    : units_(setup),
      domain_(setup, units_),
      partition_(domain_.cells(), communicator.size()),
      cell_size_m_(setup.cell_size_m),
      communicator_(communicator) {}

/// Rank that holds the cells beyond a face of a block; −1: none does.
int Vorticity::rank_beyond(const Box& block, int axis, bool high) const {
  const auto index = domain_.image(axis, high ? block.high[axis] : block.low[axis] - 1);
  if (!index) return -1;
  Cell cell = block.low;
  cell[axis] = *index;
  return partition_.owner(cell);
}

/// Beyond a face whose other side is this rank's, a wall, or open.
Vorticity::Layer Vorticity::local_layer(const FieldBlock& block, int axis, bool high) const {
  const std::int64_t beyond = high ? block.box.high[axis] : block.box.low[axis] - 1;
  const auto index = domain_.image(axis, beyond);
  std::vector<double> layer =
      velocities_in(block, layer_of(block.box, axis, index.value_or(edge(block.box, axis, high))));
  const Face& face = domain_.face(axis, high);
  if (index) return layer;  // a mirror would reverse the normal component, of which no derivative along it is needed
  if (face.is_open() || face.is_parabolic || face.signal) return std::nullopt;  // one velocity does not describe it
  for (std::size_t i = 0; i < layer.size(); ++i)
    layer[i] = 2.0 * units_.velocity_m_per_s(face.velocity_lu[static_cast<Eigen::Index>(i % 3)]) - layer[i];
  return layer;
}

/// Two ranks that share several faces, like the two halves of a periodic domain, exchange one message: layers in the
/// order of the receiver's faces.
void Vorticity::receive_layers(const FieldBlock& block, std::array<Layer, 6>& layers) const {
  struct Buffers {
    std::vector<double> send, receive;
    std::vector<std::size_t> faces;  ///< whose layers are received
  };
  std::map<int, Buffers> peers;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) {
      const std::size_t face = face_index(axis, high);
      const int sender = rank_beyond(block.box, axis, high);
      if (sender >= 0 && sender != communicator_.rank()) peers[sender].faces.push_back(face);
      // The face of the receiver opposite to this one is the same place.
      const int receiver = rank_beyond(block.box, axis, !high);
      if (receiver < 0 || receiver == communicator_.rank()) continue;
      const auto layer = velocities_in(block, layer_of(block.box, axis, edge(block.box, axis, !high)));
      peers[receiver].send.insert(peers[receiver].send.end(), layer.begin(), layer.end());
    }
  std::vector<Communicator::Message> messages;
  for (auto& [rank, buffers] : peers) {
    buffers.receive.resize(buffers.send.size());
    messages.push_back(
        {rank, std::as_bytes(std::span(buffers.send)), std::as_writable_bytes(std::span(buffers.receive))});
  }
  communicator_.start_exchange(messages)();
  for (const auto& [rank, buffers] : peers) {
    auto next = buffers.receive.begin();
    for (const std::size_t face : buffers.faces) {
      const int axis = static_cast<int>(face / 2);
      const auto size = static_cast<std::ptrdiff_t>(3 * block.box.volume() / block.box.extent(axis));
      layers[face] = std::vector<double>(next, next + size);
      next += size;
    }
  }
}

std::array<Vorticity::Layer, 6> Vorticity::layers_around(const FieldBlock& block) const {
  std::array<Layer, 6> layers;
  receive_layers(block, layers);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) {
      const int rank = rank_beyond(block.box, axis, high);
      if (rank < 0 || rank == communicator_.rank()) layers[face_index(axis, high)] = local_layer(block, axis, high);
    }
  return layers;
}

std::vector<double> Vorticity::operator()(const FieldBlock& block) const {
  const std::array<Layer, 6> layers = layers_around(block);
  const Box& box = block.box;
  /// Velocity one cell further along an axis; null beyond an open face.
  const auto beside = [&](Cell cell, int axis, bool high) -> const double* {
    cell[axis] += high ? 1 : -1;
    if (box.contains_along(axis, cell[axis])) return &block.velocity_m_per_s[3 * index_in(box, cell)];
    const Layer& layer = layers[face_index(axis, high)];
    return layer ? &(*layer)[3 * index_in(layer_of(box, axis, cell[axis]), cell)] : nullptr;
  };
  std::vector<double> result;
  result.reserve(block.velocity_m_per_s.size());
  for_each_cell(box, [&](const Cell& cell) {
    const std::size_t here = index_in(box, cell);
    double gradient[3][3] = {};  // of component i along axis j
    for (int axis = 0; axis < 3; ++axis) {
      const double* own = &block.velocity_m_per_s[3 * here];
      const double* low = beside(cell, axis, false);
      const double* high = beside(cell, axis, true);
      const double distance_m = ((low != nullptr ? 1.0 : 0.0) + (high != nullptr ? 1.0 : 0.0)) * cell_size_m_;
      if (distance_m == 0.0) continue;
      for (int i = 0; i < 3; ++i)
        gradient[i][axis] = ((high != nullptr ? high : own)[i] - (low != nullptr ? low : own)[i]) / distance_m;
    }
    const bool is_fluid = block.body[here] == 0;
    for (const auto& [i, j] : {std::pair{2, 1}, std::pair{0, 2}, std::pair{1, 0}})
      result.push_back(is_fluid ? gradient[i][j] - gradient[j][i] : 0.0);
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

std::string xdmf_text(const XdmfDescription& description) {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10);
  text << "<?xml version='1.0' encoding='utf-8'?>\n<Xdmf Version='2.0'>\n  <Domain>\n";
  const bool has_times = !description.grids.empty() && step_of_group(description.grids.front().group) >= 0;
  if (has_times) text << "    <Grid Name='snapshots' GridType='Collection' CollectionType='Temporal'>\n";
  for (const XdmfGrid& grid : description.grids) add_grid(text, description, grid, has_times ? "      " : "    ");
  if (has_times) text << "    </Grid>\n";
  text << "  </Domain>\n</Xdmf>\n";
  return text.str();
}

}  // namespace copepod::fluid
