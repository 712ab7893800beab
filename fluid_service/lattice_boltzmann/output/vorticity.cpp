#include "lattice_boltzmann/output/vorticity.hpp"

#include <map>
#include <span>

namespace copepod::fluid {

namespace {

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

}  // namespace

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
  if (face.kind == FaceKind::pressure) return std::nullopt;
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

}  // namespace copepod::fluid
