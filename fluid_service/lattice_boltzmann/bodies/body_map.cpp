#include "lattice_boltzmann/bodies/body_map.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"

namespace copepod::fluid {

BodyMap::BodyMap(const Domain& domain, const PopulationLayout& layout, std::vector<LatticeBody> bodies,
                 std::vector<std::string> obstacles)
    : domain_(domain),
      layout_(layout),
      bodies_(std::move(bodies)),
      obstacles_(std::move(obstacles)),
      mapped_(bodies_.size()),
      owner_(layout.cells(), fluid) {
  for (LatticeBody& obstacle : std::span(bodies_).last(obstacles_.size()))
    for (int axis = 0; axis < 3; ++axis)
      if (domain_.periodic(axis)) obstacle.period[axis] = static_cast<double>(domain_.cells()[axis]);
}

/// From the crossings of rows in any order.
void BodyMap::Footprint::set_rows(const std::vector<RowCrossing>& crossings) {
  const auto number = [this](const RowCrossing& c) { return static_cast<std::size_t>((c.x - x) * width + c.y - y); };
  std::vector<std::uint32_t> ends(static_cast<std::size_t>(lines * width) + 1);  // while sorting, the next place
  for (const RowCrossing& crossing : crossings) ++ends[number(crossing) + 1];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<RowCrossing> sorted(crossings.size());
  for (const RowCrossing& crossing : crossings) sorted[ends[number(crossing)]++] = crossing;
  ends.pop_back();
  auto from = sorted.begin();
  for (const std::uint32_t end : ends) {
    starts.push_back(static_cast<std::uint32_t>(rows.size()));
    const auto to = sorted.begin() + end;
    std::sort(from, to, [](const RowCrossing& a, const RowCrossing& b) {
      return std::pair(a.z, -a.step) < std::pair(b.z, -b.step);
    });
    for (int depth = 0; from != to; ++from) {
      depth += from->step;
      if (depth == 1 && from->step == 1) rows.push_back({from->z, from->z});
      if (depth != 0 || from->step == 1) continue;
      rows.back().high = from->z;
      if (rows.back().empty()) rows.pop_back();
    }
  }
  starts.push_back(static_cast<std::uint32_t>(rows.size()));
}

bool BodyMap::update(std::span<const std::int32_t> bodies) {
  uncovered_.clear();
  covered_.clear();
  changed_ = {};  // with its memory: at first it holds all cells that bodies cover
  for (const std::int32_t index : bodies) {
    Footprint& before = mapped_[index];
    const LatticeBody& body = bodies_[index];
    const bool mapped = before.width > 0;
    const bool turned = !body.is_turned_as(before.state);
    if (mapped && before.state.position == body.position && !turned) continue;
    const bool removed = !is_obstacle(index) && is_removed(body);
    if (!is_obstacle(index) && !removed) {
      check_inside(body, index);
      if (has_started_) check_clear_of_faces(body, index);
    }
    if (mapped && before.free_way.contains(body.position - before.state.position) && !turned) continue;
    if (!near_block(body) && !(mapped && near_block(before.state))) continue;
    Footprint after = removed ? before.without_cells(body) : footprint(body);
    compare(before, after, index);
    before = std::move(after);
    if (!has_started_) hand_over();  // at once, since nothing was given up: a list of all cells would take memory
  }
  hand_over();
  has_started_ = true;
  return !changed_.empty();
}

/// The same rows without cells.
BodyMap::Footprint BodyMap::Footprint::without_cells(const LatticeBody& body) const {
  Footprint result = *this;
  result.state = body;
  result.free_way = {};
  result.rows.assign(rows.size(), {});
  return result;
}

BodyMap::Footprint BodyMap::footprint(const LatticeBody& body) {
  const Eigen::AlignedBox3d box = body.bounds().translated(body.position);
  const auto first = [&](int axis) { return static_cast<std::int64_t>(std::floor(box.min()[axis])); };
  const auto last = [&](int axis) { return static_cast<std::int64_t>(std::floor(box.max()[axis])); };
  Footprint result{.state = body,
                   .free_way = {},
                   .x = first(0),
                   .y = first(1),
                   .lines = last(0) - first(0) + 1,
                   .width = last(1) - first(1) + 1,
                   .rows = {},
                   .starts = {}};
  if (body.placed) {
    std::vector<RowCrossing> crossings;
    add_crossings(body, crossings);
    result.set_rows(crossings);
    return result;
  }
  result.rows.reserve(result.lines * result.width);
  for_each_row(body.bounds(), body.position,
               [&](std::int64_t x, std::int64_t y) { result.rows.push_back(covered_cells(body, x, y)); });
  if (body.kind == ShapeKind::sphere) result.free_way = free_way(result);
  return result;
}

/// A centre at d from the sphere's is on the same side of its surface after a way w if
///   ||d|² − R²| > 2 |d·w| + |w|²,   |d·w| ≤ |w| (|d·n| + deviation |d|)
/// with the direction n of the velocity. Centres with |d| > R + 1, and those in a row behind the two on either side of
/// its ends, have a left-hand side above 3/4: they do not limit ways up to `longest`.
BodyMap::FreeWay BodyMap::free_way(const Footprint& sphere) {
  constexpr double rounding = 1e-6;  // far more than that of positions
  const Eigen::Vector3d& centre = sphere.state.position;
  const double radius = sphere.state.radius;
  const double longest = 0.5 / (2.0 * radius + 3.0);
  double nearest = 1.0;
  FreeWay result{.anywhere = longest, .ahead = longest, .direction = sphere.state.velocity.stableNormalized()};
  const Eigen::Vector3d& n = result.direction;
  const auto from_centre = [&](std::int64_t cell, int axis) { return static_cast<double>(cell) + 0.5 - centre[axis]; };
  const auto below = static_cast<std::int64_t>(std::floor(centre[2] - 0.5));
  for (std::int64_t x = sphere.x - 1; x <= sphere.x + sphere.lines; ++x)
    for (std::int64_t y = sphere.y - 1; y <= sphere.y + sphere.width; ++y) {
      const double dx = from_centre(x, 0);
      const double dy = from_centre(y, 1);
      const double outside = dx * dx + dy * dy - radius * radius;
      const double across = dx * n[0] + dy * n[1];
      const auto look_at = [&](std::int64_t z) {
        const double dz = from_centre(z, 2);
        const double difference = std::abs(outside + dz * dz);
        const double d_dot_n = std::abs(across + dz * n[2]) + FreeWay::deviation * (radius + 1.0);
        nearest = std::min(nearest, difference);
        result.ahead = std::min(result.ahead, difference / (2.0 * d_dot_n + longest));
      };
      const std::span<const RowInterval> row = sphere.row(x, y);
      if (row.empty() || row[0].empty()) {
        for (const std::int64_t z : {below, below + 1}) look_at(z);
      } else {
        const auto [low, high] = row[0];
        for (const std::int64_t z : {low - 1, low, high - 1, high}) look_at(z);
      }
    }
  result.anywhere = std::min(longest, nearest / (2.0 * (radius + 1.0) + longest)) - rounding;
  result.ahead -= rounding;
  return result;
}

/// Whether the body or an image of it can cover a cell of the block or its ghosts.
bool BodyMap::near_block(const LatticeBody& body) const {
  const Eigen::AlignedBox3d bounds = body.bounds();
  const Box& block = layout_.block();
  for (int axis = 0; axis < 3; ++axis) {
    const auto cells = static_cast<double>(domain_.cells()[axis]);
    const double low = static_cast<double>(block.low[axis]) - (bounds.max()[axis] + 2.0);
    const double high = static_cast<double>(block.high[axis]) + (2.0 - bounds.min()[axis]);
    double x = body.position[axis];
    if (domain_.periodic(axis)) x -= cells * std::floor((x - low) / cells);  // the first image at or above low
    if (x < low || x > high) return false;
  }
  return true;
}

void BodyMap::compare(const Footprint& before, const Footprint& after, std::int32_t body) {
  if (before.x == after.x && before.y == after.y && before.width == after.width && before.lines == after.lines) {
    for (std::int64_t i = 0; i < after.lines * after.width; ++i)
      compare_rows(before.row(i), after.row(i), {after.x + i / after.width, after.y + i % after.width, 0}, body);
    return;
  }
  const bool fresh_map = before.width == 0;
  const std::int64_t x0 = fresh_map ? after.x : std::min(before.x, after.x);
  const std::int64_t y0 = fresh_map ? after.y : std::min(before.y, after.y);
  const std::int64_t x1 = std::max(fresh_map ? after.x : before.x + before.lines, after.x + after.lines);
  const std::int64_t y1 = std::max(fresh_map ? after.y : before.y + before.width, after.y + after.width);
  for (std::int64_t x = x0; x < x1; ++x)
    for (std::int64_t y = y0; y < y1; ++y) compare_rows(before.row(x, y), after.row(x, y), {x, y, 0}, body);
}

void BodyMap::compare_rows(std::span<const RowInterval> before, std::span<const RowInterval> after, Cell row,
                           std::int32_t body) {
  if (std::ranges::equal(before, after)) return;
  const auto inside = [](std::span<const RowInterval> intervals, std::int64_t z) {
    return std::ranges::any_of(intervals, [z](const RowInterval& i) { return z >= i.low && z < i.high; });
  };
  for (const RowInterval& interval : before)
    for (row[2] = interval.low; row[2] < interval.high; ++row[2]) {
      if (inside(after, row[2])) continue;
      for_each_image(row, [&](const Cell& cell) { give_up(cell, body); });
    }
  for (const RowInterval& interval : after)
    for (row[2] = interval.low; row[2] < interval.high; ++row[2])
      if (!inside(before, row[2])) for_each_image(row, [&](const Cell& cell) { claimed_.emplace_back(cell, body); });
}

template <class Visit>
void BodyMap::for_each_image(const Cell& unwrapped, const Visit& visit) const {
  const Box& block = layout_.block();
  std::array<std::array<std::int64_t, 3>, 3> images{};
  std::array<int, 3> count{};
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t cells = domain_.cells()[axis];
    const auto add = [&](std::int64_t index) {
      if (index < block.low[axis] - 1 || index > block.high[axis]) return;
      if (!domain_.image(axis, index)) return;  // beyond a wall there is nothing to cover
      images[axis][count[axis]++] = index;
    };
    if (domain_.periodic(axis)) {
      for (const std::int64_t shift : {-cells, std::int64_t{0}, cells}) add(wrapped(unwrapped[axis], cells) + shift);
    } else if (unwrapped[axis] >= 0 && unwrapped[axis] < cells) {
      add(unwrapped[axis]);
      // The ghost behind a mirror is covered when the cell before it is.
      for (const std::int64_t ghost : {std::int64_t{-1}, cells})
        if (domain_.image(axis, ghost) == unwrapped[axis]) add(ghost);
    }
  }
  for (int i = 0; i < count[0]; ++i)
    for (int j = 0; j < count[1]; ++j)
      for (int k = 0; k < count[2]; ++k) visit(Cell{images[0][i], images[1][j], images[2][k]});
}

void BodyMap::give_up(const Cell& cell, std::int32_t body) {
  const auto behind = behind_.find({layout_.cell(cell), body});
  if (behind == behind_.end())
    given_up_.emplace_back(cell, body);
  else
    behind_.erase(behind);
}

/// When every body has been compared, each of these cells goes to the first body that covers it, whatever they did
/// before: if its owner left, to the first of those behind it that stayed, unless one before that has come.
void BodyMap::hand_over() {
  for (const ChangedCell& g : given_up_) {
    const std::int64_t index = layout_.cell(g.cell());
    std::int32_t& owner = owner_[index];
    const auto next = behind_.lower_bound({index, 0});
    changed_.push_back(g);
    if (next == behind_.end() || next->first != index) {
      owner = fresh;
      uncovered_.push_back(g);
      continue;
    }
    owner = next->second + 1;
    changed_.emplace_back(g.cell(), next->second);
    behind_.erase(next);
  }
  for (const ChangedCell& c : claimed_) {
    const std::int64_t index = layout_.cell(c.cell());
    std::int32_t& owner = owner_[index];
    if (owner > fluid) {
      const std::int32_t other = owner - 1;
      check_apart(other, c.body);
      behind_.emplace(index, std::max(other, c.body));
      if (other <= c.body) continue;
      changed_.emplace_back(c.cell(), other);
    } else if (owner == fluid && has_started_) {
      covered_.push_back(c);
    }
    owner = c.body + 1;
    changed_.push_back(c);
  }
  given_up_.clear();
  claimed_.clear();
  std::erase_if(uncovered_, [this](const ChangedCell& u) { return owner_[layout_.cell(u.cell())] != fresh; });
}

/// Both cover a cell.
void BodyMap::check_apart(std::int32_t body, std::int32_t other) const {
  if (is_obstacle(body) == is_obstacle(other)) return;
  const auto [first, last] = std::minmax(body, other);
  throw SolverError("body " + std::to_string(first) + " met obstacle '" +
                    obstacles_[static_cast<std::size_t>(last) + obstacles_.size() - bodies_.size()] +
                    "' (obstacles push nothing back). Keep it away, or make the obstacle a body with motion: fixed, "
                    "and let bodies rebound (contact: {}).");
}

void BodyMap::accept_fresh_cells() {
  for (const ChangedCell& u : uncovered_) owner_[layout_.cell(u.cell())] = fluid;
}

bool BodyMap::is_removed(const LatticeBody& body) const {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) {
      // Behind the plane that cuts a domain its other face is as this one.
      if (!domain_.face(axis, high && !domain_.symmetric(axis)).removes_bodies) continue;
      const Eigen::AlignedBox3d box = body.bounds().translated(body.position);
      const double length = static_cast<double>(domain_.cells()[axis]) * (domain_.symmetric(axis) ? 2.0 : 1.0);
      if (high ? box.min()[axis] >= length : box.max()[axis] <= 0.0) return true;
    }
  return false;
}

void BodyMap::check_inside(const LatticeBody& body, std::size_t index) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double x = body.position[axis];
    // A whole domain is twice the computed one where a symmetry plane cuts it.
    const double length = static_cast<double>(domain_.cells()[axis]) * (domain_.symmetric(axis) ? 2.0 : 1.0);
    if (!std::isfinite(x) || !std::isfinite(body.axis[axis]))
      throw SolverError("position of body " + std::to_string(index) +
                        " is not finite (the body solver diverged). Use a shorter step or softer springs.");
    if (!domain_.periodic(axis) && (x < 0.0 || x > length))
      throw SolverError("body " + std::to_string(index) + " left the domain through a face normal to " + "xyz"[axis] +
                        " (its centre is at " + std::to_string(x) + " cells). Enlarge the domain or make it periodic.");
    if (domain_.symmetric(axis) && beyond(body, axis, true) > 0.0)
      throw SolverError("body " + std::to_string(index) + " reached the symmetry plane normal to " + "xyz"[axis] +
                        " (behind it comes its mirror image). Start it further away, or remove the plane.");
  }
}

void BodyMap::check_clear_of_faces(const LatticeBody& body, std::size_t index) const {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) {
      if (beyond(body, axis, high) <= domain_.wall_overlap_lu()) continue;
      throw SolverError("body " + std::to_string(index) + " runs into the " + (high ? "upper" : "lower") +
                        " face normal to " + "xyz"[axis] + " (its centre is at " + std::to_string(body.position[axis]) +
                        " cells; its loads would be those of a part of it). " +
                        (domain_.wall_overlap_lu() > 0.0
                             ? "Make the contact stiffer (contact.stiffness_N_per_m), or push it more softly."
                             : "Let bodies rebound (contact: {} in the case), enlarge the domain, or keep it away with "
                               "a softer push or a spring."));
    }
}

double BodyMap::beyond(const LatticeBody& body, int axis, bool high) const {
  const FaceKind kind = domain_.face(axis, high).kind;
  if (kind == FaceKind::periodic || (high && domain_.cut_by_symmetry_plane(body.position, axis))) return -1.0;
  const Eigen::AlignedBox3d bounds = body.bounds();
  const double x = body.position[axis];
  return high ? x + bounds.max()[axis] - static_cast<double>(domain_.cells()[axis]) : -bounds.min()[axis] - x;
}

}  // namespace copepod::fluid
