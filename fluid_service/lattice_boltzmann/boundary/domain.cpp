#include "lattice_boltzmann/boundary/domain.hpp"

#include <cmath>

#include "contract/errors.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"

namespace copepod::fluid {

namespace {

Face make_face(const Boundary& boundary, const LatticeUnits& units) {
  Face face;
  switch (boundary.kind) {
    case BoundaryKind::periodic:
      face.kind = FaceKind::periodic;
      break;
    case BoundaryKind::free_slip:
      face.kind = FaceKind::mirror;
      break;
    case BoundaryKind::pressure:
      face.kind = FaceKind::pressure;
      face.excess_density_lu = units.excess_density_lu(boundary.pressure_Pa);
      break;
    case BoundaryKind::velocity:
      face.velocity_lu = units.velocity_lu(boundary.velocity_m_per_s);
      break;
    case BoundaryKind::no_slip:
      break;
  }
  return face;
}

}  // namespace

Domain::Domain(const FluidSetup& setup, const LatticeUnits& units)
    : cells_(setup.domain_cells), symmetric_(setup.symmetry_planes) {
  constexpr const char* axis_name = "xyz";
  for (int axis = 0; axis < 3; ++axis) {
    if (cells_[axis] < 1)
      throw CaseError(
          "domain_cells has no cell along an axis (a domain needs at least one). Make it larger.");
    Face& low = faces_[face_index(axis, false)];
    Face& high = faces_[face_index(axis, true)];
    low = make_face(setup.boundaries[face_index(axis, false)], units);
    high = make_face(setup.boundaries[face_index(axis, true)], units);
    const bool low_periodic = low.kind == FaceKind::periodic;
    if (low_periodic != (high.kind == FaceKind::periodic))
      throw CaseError(
          std::string("only one face of axis ") + axis_name[axis] +
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

std::optional<Cell> Domain::canonical(const Cell& cell) const {
  Cell result = cell;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t cells = cells_[axis];
    if (result[axis] >= 0 && result[axis] < cells) continue;
    const bool high = result[axis] >= cells;
    switch (face(axis, high).kind) {
      case FaceKind::periodic:
        result[axis] += high ? -cells : cells;
        break;
      case FaceKind::mirror:
        result[axis] = high ? 2 * cells - 1 - result[axis] : -1 - result[axis];
        break;
      case FaceKind::wall:
      case FaceKind::pressure:
        return std::nullopt;
    }
  }
  return result;
}

Eigen::Vector3d Domain::from_position(const Eigen::Vector3d& position_lu, const Cell& cell) const {
  Eigen::Vector3d r;
  for (int axis = 0; axis < 3; ++axis) {
    r[axis] = (static_cast<double>(cell[axis]) + 0.5) - position_lu[axis];
    if (periodic(axis)) {
      const auto length = static_cast<double>(cells_[axis]);
      r[axis] -= length * std::round(r[axis] / length);
    }
  }
  return r;
}

GhostSource ghost_source(const Domain& domain, const Cell& ghost, int direction) {
  GhostSource source{.cell = ghost, .direction = direction};
  bool wall = false;
  bool pressure = false;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t cells = domain.cells()[axis];
    if (ghost[axis] >= 0 && ghost[axis] < cells) continue;
    const bool high = ghost[axis] >= cells;
    const Face& face = domain.face(axis, high);
    switch (face.kind) {
      case FaceKind::periodic:
        source.cell[axis] += high ? -cells : cells;
        break;
      case FaceKind::mirror:
        source.cell[axis] = high ? 2 * cells - 1 - ghost[axis] : -1 - ghost[axis];
        source.direction = d3q19::mirrored(source.direction, axis);
        break;
      case FaceKind::wall: {
        wall = true;
        // f_ᾱ(x_f) = f̃_α(x_f) + 6 w_α ρ_w e_ᾱ·u_w with ρ_w = 1             [paper, moving-wall bounce-back]
        const auto& e = d3q19::e[direction];
        source.addition +=
            6.0 * d3q19::weight(direction) *
            (e[0] * face.velocity_lu[0] + e[1] * face.velocity_lu[1] + e[2] * face.velocity_lu[2]);
        break;
      }
      case FaceKind::pressure:
        pressure = true;
        source.excess_density = face.excess_density_lu;
        break;
    }
  }
  if (!wall && !pressure) return source;
  // Walls win over everything else that meets them in an edge: the population bounces back to where it came
  // from.
  const auto& e = d3q19::e[direction];
  source.cell = {ghost[0] + e[0], ghost[1] + e[1], ghost[2] + e[2]};
  source.direction = d3q19::opposite(direction);
  source.kind = wall ? GhostSource::Kind::copy : GhostSource::Kind::pressure;
  return source;
}

}  // namespace copepod::fluid
