#include "lattice_boltzmann/output/flow_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace copepod::fluid {

namespace {

constexpr std::size_t totals = 6;
constexpr std::size_t sums_of_probe = 5;  ///< weighted: velocity, excess density, and the weights of this one

constexpr std::size_t sums_of_face = 4;  ///< mass that comes in, and force
constexpr std::size_t faces = 6;

/// Sums in lattice units are whole numbers of 2⁻⁷⁰, in which those of 10¹² cells fit.
constexpr double resolution = 0x1p-70;

/// As two whole numbers of 64 bits, which processors convert at once.
fixed_point::Sum whole(double value) {
  const std::int64_t high = std::llrint(value * 0x1p40);
  return (fixed_point::Sum{high} << 30) +
         std::llrint((value - static_cast<double>(high) * 0x1p-40) * (1.0 / resolution));
}

}  // namespace

FlowSampler::FlowSampler(const FluidSetup& setup, const Domain& domain, const Box& block, Communicator& communicator)
    : setup_(setup), domain_(domain), block_(block), communicator_(communicator) {
  for (const Probe& probe : setup.flow.probes)
    probes_.push_back(corners_around(LatticeUnits(setup).position_lu(probe.position_m), domain));
}

auto FlowSampler::corners_around(const Eigen::Vector3d& position_lu, const Domain& domain) -> std::vector<Corner> {
  std::vector<Corner> corners(8);
  for (std::size_t number = 0; number < corners.size(); ++number) {
    Corner& corner = corners[number];
    for (int axis = 0; axis < 3; ++axis) {
      const double place = position_lu[axis] - 0.5, below = std::floor(place);
      const bool is_above = (number >> axis) % 2 == 1;
      corner.weight *= is_above ? place - below : 1.0 - (place - below);
      const std::int64_t cells = domain.cells()[axis];
      std::int64_t index = static_cast<std::int64_t>(below) + (is_above ? 1 : 0);
      if (domain.symmetric(axis) && index >= cells) {
        index = reflected(index, cells);
        corner.sign[axis] *= -1.0;
      }
      const bool is_beyond = index < 0 || index >= cells;
      if (is_beyond && domain.face(axis, index >= cells).kind == FaceKind::mirror) corner.sign[axis] *= -1.0;
      corner.cell[axis] = domain.image(axis, index).value_or(std::clamp<std::int64_t>(index, 0, cells - 1));
    }
  }
  return corners;
}

void FlowSampler::add_totals(const FieldBlock& block, fixed_point::Sum* sums) const {
  const VelocityGradient gradient(setup_, block, communicator_);
  const double per_speed = setup_.step_s / setup_.cell_size_m;
  std::size_t number = 0;
  for_each_cell(block.box, [&](const Cell& cell) {
    const std::size_t at = number++;
    if (block.body[at] != 0) return;
    const double density = block.density_kg_per_m3[at] / setup_.density_kg_per_m3;
    const Eigen::Vector3d velocity = per_speed * Eigen::Map<const Eigen::Vector3d>(&block.velocity_m_per_s[3 * at]);
    const Eigen::Matrix3d g = per_speed * gradient(cell);
    sums[0] += whole(0.5 * density * velocity.squaredNorm());
    sums[1] += whole((0.5 * (g + g.transpose())).squaredNorm());
    sums[2] += whole(0.25 * (g - g.transpose()).squaredNorm());  // ½ ω²
    for (int axis = 0; axis < 3; ++axis) sums[3 + axis] += whole(density * velocity[axis]);
  });
}

void FlowSampler::add_probe(const std::vector<Corner>& corners, const std::function<FieldBlock(const Box&)>& fields,
                            fixed_point::Sum* sums) const {
  for (const Corner& corner : corners) {
    if (!block_.contains(corner.cell) || corner.weight == 0.0) continue;
    const Cell& low = corner.cell;
    const FieldBlock found = fields({low, {low[0] + 1, low[1] + 1, low[2] + 1}});
    for (int axis = 0; axis < 3; ++axis)
      sums[axis] +=
          whole(corner.weight * corner.sign[axis] * found.velocity_m_per_s[axis] * setup_.step_s / setup_.cell_size_m);
    if (found.body[0] != 0) continue;
    sums[3] += whole(corner.weight * (found.density_kg_per_m3[0] / setup_.density_kg_per_m3 - 1.0));
    sums[4] += whole(corner.weight);
  }
}

void FlowSampler::add_crossing(const Crossing& crossing, fixed_point::Sum* sums) const {
  const auto lets_through = [this](int axis, bool high) {
    return domain_.face(axis, high).kind == FaceKind::inflow || domain_.face(axis, high).is_open();
  };
  std::array<fixed_point::Sum*, 3> normal_to{};  // by axis: of the face that the component along it is normal to
  fixed_point::Sum* tangential_to = nullptr;
  fixed_point::Sum* open = nullptr;
  for (int axis = 0; axis < 3; ++axis) {
    if (domain_.box().contains_along(axis, crossing.ghost[axis]) || domain_.periodic(axis)) continue;
    const bool high = crossing.ghost[axis] >= 0;
    fixed_point::Sum* const face = sums + sums_of_face * face_index(axis, high);
    normal_to[axis] = face;
    if (domain_.face(axis, high).kind != FaceKind::mirror) tangential_to = face;
    if (lets_through(axis, high)) open = face;
  }
  if (open != nullptr) *open += whole(crossing.entering - crossing.leaving);
  for (int axis = 0; axis < 3; ++axis) {
    const int e = d3q19::e[crossing.direction][axis];
    fixed_point::Sum* const normal = normal_to[axis];
    fixed_point::Sum* const face = normal != nullptr ? normal : tangential_to;
    if (e == 0 || face == nullptr) continue;
    const double lost = -e * (crossing.leaving + crossing.entering);
    face[1 + axis] += whole(lost);
    if (normal != nullptr) continue;
    const std::int64_t place = std::max(crossing.ghost[axis], crossing.ghost[axis] + e);  // of the link on the face
    for (const bool high : {false, true}) {
      if (place != (high ? domain_.cells()[axis] - 1 : 1) || !lets_through(axis, high)) continue;
      face[1 + axis] += whole(0.5 * lost);
      sums[sums_of_face * face_index(axis, high) + 1 + static_cast<std::size_t>(axis)] -= whole(0.5 * lost);
    }
  }
}

Eigen::VectorXd FlowSampler::operator()(const std::function<FieldBlock(const Box&)>& fields,
                                        const std::function<void(const VisitCrossing&)>& crossings) const {
  const std::size_t first = setup_.flow.totals ? totals : 0;
  const std::size_t first_of_faces = first + sums_of_probe * probes_.size();
  std::vector<fixed_point::Sum> sums(first_of_faces + (setup_.flow.faces.empty() ? 0 : sums_of_face * faces));
  if (setup_.flow.totals) add_totals(fields(block_), sums.data());
  for (std::size_t i = 0; i < probes_.size(); ++i)
    add_probe(probes_[i], fields, sums.data() + first + sums_of_probe * i);
  if (!setup_.flow.faces.empty())
    crossings([&](const Crossing& crossing) { add_crossing(crossing, sums.data() + first_of_faces); });

  std::vector<fixed_point::Halves> halves(sums.size());
  std::ranges::transform(sums, halves.begin(), fixed_point::halves);
  communicator_.sum_to_leader(std::span(reinterpret_cast<std::int64_t*>(halves.data()), 2 * halves.size()));
  if (communicator_.rank() != 0) return {};
  const auto sum_of = [&](std::size_t number) {
    return static_cast<double>(fixed_point::from_halves(halves[number][0], halves[number][1])) * resolution;
  };

  Eigen::VectorXd values(setup_.flow.values_in(0));
  const double volume = std::pow(setup_.cell_size_m, 3), speed = setup_.cell_size_m / setup_.step_s;
  const double density = setup_.density_kg_per_m3, rate2 = 1.0 / (setup_.step_s * setup_.step_s);
  if (setup_.flow.totals) {
    const double images = std::pow(2.0, std::ranges::count(setup_.symmetry_planes, true));
    values[0] = images * density * volume * speed * speed * sum_of(0);
    values[1] = images * 2.0 * density * setup_.kinematic_viscosity_m2_per_s * volume * rate2 * sum_of(1);
    values[2] = images * volume * rate2 * sum_of(2);
    for (std::size_t axis = 0; axis < 3; ++axis)
      values[3 + axis] = setup_.symmetry_planes[axis] ? 0.0 : images * density * volume * speed * sum_of(3 + axis);
  }
  auto value = values.begin() + static_cast<Eigen::Index>(first);
  for (std::size_t number = first; number < first_of_faces; number += sums_of_probe) {
    for (std::size_t axis = 0; axis < 3; ++axis) *value++ = speed * sum_of(number + axis);
    const double weight = sum_of(number + 4);
    *value++ = weight > 0.0 ? sum_of(number + 3) / weight / LatticeUnits(setup_).excess_density_lu(1.0) : 0.0;
  }
  for (const std::int64_t face : setup_.flow.faces) {
    const auto normal = static_cast<std::size_t>(face / 2);
    const std::array<bool, 3>& is_plane = setup_.symmetry_planes;
    const bool is_image = is_plane[normal] && face % 2 == 1;
    const std::size_t number = first_of_faces + sums_of_face * static_cast<std::size_t>(is_image ? face - 1 : face);
    const double images = std::pow(2.0, std::ranges::count(is_plane, true) - (is_plane[normal] ? 1 : 0));
    *value++ = images * volume / setup_.step_s * sum_of(number);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double reflected = axis == normal ? (is_image ? -1.0 : 1.0) : (is_plane[axis] ? 0.0 : 1.0);
      *value++ = images * reflected * LatticeUnits(setup_).force_N(sum_of(number + 1 + axis));
    }
  }
  return values;
}

}  // namespace copepod::fluid
