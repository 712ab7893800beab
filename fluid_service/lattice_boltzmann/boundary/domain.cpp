#include "lattice_boltzmann/boundary/domain.hpp"

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/wall.hpp"

namespace copepod::fluid {

namespace {

Face make_face(const FluidSetup& setup, std::size_t number, const LatticeUnits& units) {
  const Boundary& boundary = setup.boundaries[number];
  Face face;
  if (boundary.kind == BoundaryKind::periodic) face.kind = FaceKind::periodic;
  if (boundary.kind == BoundaryKind::free_slip) face.kind = FaceKind::mirror;
  if (boundary.kind == BoundaryKind::velocity) face.velocity_lu = units.velocity_lu(boundary.velocity_m_per_s);
  if (boundary.lets_in(number)) face.kind = FaceKind::inflow;
  face.is_parabolic = boundary.parabolic;
  face.removes_bodies = boundary.removes_bodies;
  face.profile = boundary.profile;
  const std::int64_t cells = setup.domain_cells[(number / 2 + 1) % 3] * setup.domain_cells[(number / 2 + 2) % 3];
  if (!face.profile.empty() && std::ssize(face.profile) != cells)
    throw CaseError("the profile of a face has " + std::to_string(face.profile.size()) + " factors, not " +
                    std::to_string(cells) + " (one for each of its cells). Give as many.");
  if (boundary.kind == BoundaryKind::velocity) face.signal = boundary.signal;
  if (face.signal) face.factor += 0.1 * static_cast<double>(number);
  if (boundary.kind == BoundaryKind::outflow) face.kind = FaceKind::outflow;
  if (boundary.kind == BoundaryKind::pressure) {
    face.kind = FaceKind::pressure;
    face.excess_density_lu = units.excess_density_lu(boundary.pressure_Pa);
  }
  return face;
}

}  // namespace

Domain::Domain(const FluidSetup& setup, const LatticeUnits& units)
    : cells_(setup.domain_cells),
      symmetric_(setup.symmetry_planes),
      wall_overlap_lu_(units.length_lu(setup.wall_overlap_m)) {
  constexpr const char* axis_name = "xyz";
  for (int axis = 0; axis < 3; ++axis) {
    if (cells_[axis] < 1)
      throw CaseError("domain_cells has no cell along an axis (a domain needs at least one). Make it larger.");
    Face& low = faces_[face_index(axis, false)];
    Face& high = faces_[face_index(axis, true)];
    low = make_face(setup, face_index(axis, false), units);
    high = make_face(setup, face_index(axis, true), units);
    const bool low_periodic = low.kind == FaceKind::periodic;
    if (low_periodic != (high.kind == FaceKind::periodic))
      throw CaseError(std::string("only one face of axis ") + axis_name[axis] +
                      " is periodic (what leaves through one must enter through the other). Make both periodic.");
    if (!symmetric_[axis]) continue;
    if (cells_[axis] % 2 != 0)
      throw CaseError(
          std::string("symmetry plane normal to ") + axis_name[axis] +
          " in a domain with an odd number of cells (the plane must lie on cell faces). Use an even number.");
    cells_[axis] /= 2;
    // A domain that is periodic and symmetric about its middle is symmetric about its ends too.
    if (low_periodic) low.kind = FaceKind::mirror;
    high = Face{.kind = FaceKind::mirror};
  }
}

std::optional<std::int64_t> Domain::image(int axis, std::int64_t index) const {
  const std::int64_t cells = cells_[axis];
  if (index >= 0 && index < cells) return index;
  switch (face(axis, index >= cells).kind) {
    case FaceKind::periodic:
      return wrapped(index, cells);
    case FaceKind::mirror:
      return reflected(index, cells);
    case FaceKind::outflow:
    case FaceKind::pressure:
    case FaceKind::inflow:
    case FaceKind::wall:
      break;
  }
  return std::nullopt;
}

std::optional<Cell> Domain::canonical(const Cell& cell) const {
  Cell result;
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = image(axis, cell[axis]);
    if (!index) return std::nullopt;
    result[axis] = *index;
  }
  return result;
}

int Domain::mirrored(int alpha, const Cell& cell) const {
  for (int axis = 0; axis < 3; ++axis) {
    const bool high = cell[axis] >= cells_[axis];
    if ((cell[axis] < 0 || high) && face(axis, high).kind == FaceKind::mirror) alpha = d3q19::mirrored(alpha, axis);
  }
  return alpha;
}

double Domain::profile(int axis, bool high, const Cell& ghost, int direction) const {
  const Face& own = face(axis, high);
  double share = 1.0;
  for (int across = 0; across < 3 && own.is_parabolic; ++across) {
    const bool walls[] = {face(across, false).kind == FaceKind::wall, face(across, true).kind == FaceKind::wall};
    if (across == axis || (!walls[0] && !walls[1])) continue;
    const double place = static_cast<double>(ghost[across]) + 0.5 + 0.5 * d3q19::e[direction][across];
    double s = place / static_cast<double>(cells_[across]);
    if (!walls[0]) s = 0.5 * (1.0 + s);  // the other half lies beyond the mirror
    if (!walls[1]) s *= 0.5;
    share *= 4.0 * s * (1.0 - s);
  }
  if (own.profile.empty()) return share;
  const auto factor = [&](std::int64_t of_link) {
    std::int64_t place = 0;
    for (int across = 0; across < 3; ++across) {
      if (across == axis) continue;
      const std::int64_t cell = ghost[across] + of_link * d3q19::e[direction][across];
      const std::int64_t nearest = std::clamp<std::int64_t>(cell, 0, cells_[across] - 1);
      place = place * cells_[across] * (symmetric_[across] ? 2 : 1) + image(across, cell).value_or(nearest);
    }
    return own.profile[place];
  };
  return 0.5 * (factor(0) + factor(1));  // a link crosses the face between its cells
}

LinkToBody Domain::link_to_body(const Eigen::Vector3d& position_lu, const Cell& cell, int direction) const {
  LinkToBody link{from_position(position_lu, cell), direction};
  for (int axis = 0; axis < 3; ++axis) {
    const int e = d3q19::e[direction][axis];
    if (periodic(axis)) {
      link.r[axis] = to_nearest_image(link.r[axis] + e, static_cast<double>(cells_[axis])) - e;
    } else if (through_mirror(position_lu, cell, axis, e)) {
      // The mirror image of a cell at the plane is the next one beyond it.
      link.r[axis] = static_cast<double>(cell[axis] + e) + 0.5 - position_lu[axis];
      link.direction = d3q19::mirrored(link.direction, axis);
    }
  }
  return link;
}

GhostSource ghost_source(const Domain& domain, const Cell& ghost, int direction) {
  using Kind = GhostSource::Kind;
  GhostSource source{.cell = ghost, .direction = direction};
  FaceKind strongest = FaceKind::periodic;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t cells = domain.cells()[axis];
    if (ghost[axis] >= 0 && ghost[axis] < cells) continue;
    const bool high = ghost[axis] >= cells;
    const Face& face = domain.face(axis, high);
    if (const auto image = domain.image(axis, ghost[axis])) {
      source.cell[axis] = *image;
      if (face.kind == FaceKind::mirror) source.direction = d3q19::mirrored(source.direction, axis);
      continue;
    }
    if (face.kind < strongest) continue;
    if (face.kind != FaceKind::wall || strongest != FaceKind::wall) source.addition = 0.0;  // walls add up
    source.profile = domain.profile(axis, high, ghost, direction);
    if (!face.is_open())
      source.addition += moving_wall_addition(direction, source.profile * (face.factor * face.velocity_lu));
    strongest = face.kind;
    source.kind = face.is_open() ? Kind::open : Kind::wall;
    source.axis = axis;
    source.high = high;
  }
  if (source.kind == Kind::image) return source;
  const auto& e = d3q19::e[direction];
  source.cell = {ghost[0] + e[0], ghost[1] + e[1], ghost[2] + e[2]};
  source.direction = d3q19::opposite(direction);
  return source;
}

OriginRule origin_rule(const Domain& domain, const Box& block) {
  return [&domain, block](Faces faces, int direction) {
    // A cell on these faces, and the one behind it where the population comes through a face of the domain.
    Cell entered = block.low;
    Cell ghost = block.low;
    std::array<bool, 3> through{};
    for (int axis = 0; axis < 3; ++axis) {
      const int e = d3q19::e[direction][axis];
      const bool high = e < 0;
      if (e == 0 || (faces & face_bit(axis, high)) == 0) continue;
      entered[axis] = high ? block.high[axis] - 1 : block.low[axis];
      through[axis] = !domain.box().contains_along(axis, entered[axis] - e);
      ghost[axis] = through[axis] ? entered[axis] - e : entered[axis];
    }
    const GhostSource source = ghost_source(domain, ghost, direction);
    if (source.kind != GhostSource::Kind::image) return Origin{{0, 0, 0}, source.direction};
    Origin origin = straight(direction);
    origin.direction = source.direction;
    for (int axis = 0; axis < 3; ++axis)
      if (through[axis] && block.contains_along(axis, source.cell[axis]))
        origin.offset[axis] = source.cell[axis] - entered[axis];
    return origin;
  };
}

}  // namespace copepod::fluid
