#include "bodies/body_map.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "contract/errors.hpp"

namespace copepod::fluid {

BodyMap::BodyMap(const Domain& domain, const PopulationLayout& layout, std::vector<LatticeBody> bodies)
    : domain_(domain),
      layout_(layout),
      bodies_(std::move(bodies)),
      mapped_(bodies_.size()),
      owner_(static_cast<std::size_t>(layout.cells()), fluid) {}

bool BodyMap::update() {
  uncovered_.clear();
  covered_.clear();
  changed_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Mapped& mapped = mapped_[b];
    const LatticeBody& body = bodies_[b];
    const bool never = mapped.slack < 0.0;
    if (!never && moved(mapped.state, body) < mapped.slack) continue;
    check_inside(body, b);

    std::vector<Box> boxes = reach(body);
    if (!never) {
      const std::vector<Box> before = reach(mapped.state);
      for (const Box& box : before)
        if (std::find(boxes.begin(), boxes.end(), box) == boxes.end()) boxes.push_back(box);
    }
    // Half a cell is closer than any centre outside the boxes can be.
    double slack = 0.5;
    for (const Box& box : boxes) {
      bool any = false;
      map_box(static_cast<std::int32_t>(b), box, slack, any);
      if (any) changed_.push_back(box);
    }
    mapped.state = body;
    mapped.slack = slack;
  }
  cover_cells();
  return !changed_.empty();
}

void BodyMap::cover_cells() {
  for (const ChangedCell& c : covered_) {
    std::int32_t& owner = owner_[static_cast<std::size_t>(layout_.cell(c.cell))];
    if (owner == fresh) std::erase_if(uncovered_, [&](const ChangedCell& u) { return u.cell == c.cell; });
    if (owner <= fluid) owner = c.body + 1;
  }
}

void BodyMap::map_box(std::int32_t body, const Box& box, double& slack, bool& any) {
  const LatticeBody& shape = bodies_[static_cast<std::size_t>(body)];
  for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
      for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) {
        // The domain cell that a ghost stands for decides, so that every rank decides by the same arithmetic.
        const auto cell = domain_.canonical({x, y, z});
        if (!cell) continue;
        const double distance = shape.signed_distance(domain_.from_position(shape.position, *cell));
        slack = std::min(slack, std::abs(distance));
        std::int32_t& owner = owner_[static_cast<std::size_t>(layout_.cell(Cell{x, y, z}))];
        if (distance < 0.0) {
          if (owner == body + 1) continue;
          covered_.push_back({{x, y, z}, body});
          any = true;
        } else if (owner == body + 1) {
          owner = fresh;
          uncovered_.push_back({{x, y, z}, body});
          any = true;
        }
      }
}

void BodyMap::accept_fresh_cells() {
  for (const ChangedCell& u : uncovered_) owner_[static_cast<std::size_t>(layout_.cell(u.cell))] = fluid;
}

/// Bound on how far any surface point can have moved: |ΔX| and, for a capsule, the swing of its axis.
double BodyMap::moved(const LatticeBody& from, const LatticeBody& to) const {
  return (to.position - from.position).norm() + to.half_length * (to.axis - from.axis).norm();
}

void BodyMap::check_inside(const LatticeBody& body, std::size_t index) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double x = body.position[axis];
    // A whole domain is twice the computed one where a symmetry plane cuts it.
    const double length = static_cast<double>(domain_.cells()[axis]) * (domain_.symmetric(axis) ? 2.0 : 1.0);
    if (!std::isfinite(x))
      throw SolverError("position of body " + std::to_string(index) +
                        " is not finite (the body solver diverged). Use a shorter step or softer springs.");
    if (!domain_.periodic(axis) && (x < 0.0 || x > length))
      throw SolverError("body " + std::to_string(index) + " left the domain through a face normal to " +
                        "xyz"[axis] + " (its centre is at " + std::to_string(x) +
                        " cells). Enlarge the domain or make it periodic.");
  }
}

std::vector<Box> BodyMap::reach(const LatticeBody& body) const {
  const Eigen::Vector3d half = body.half_extents();
  const Box& block = layout_.block();
  std::array<std::vector<std::pair<std::int64_t, std::int64_t>>, 3> spans;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cells = static_cast<double>(domain_.cells()[axis]);
    const double centre = domain_.periodic(axis)
                              ? body.position[axis] - cells * std::floor(body.position[axis] / cells)
                              : body.position[axis];
    for (int image = -1; image <= 1; ++image) {
      if (image != 0 && !domain_.periodic(axis)) continue;
      const double x = centre + image * cells;
      const auto low =
          std::max(static_cast<std::int64_t>(std::floor(x - half[axis] - 1.0)), block.low[axis] - 1);
      const auto high =
          std::min(static_cast<std::int64_t>(std::ceil(x + half[axis] + 1.0)), block.high[axis] + 1);
      if (low < high) spans[axis].emplace_back(low, high);
    }
  }
  std::vector<Box> boxes;
  for (const auto& [x0, x1] : spans[0])
    for (const auto& [y0, y1] : spans[1])
      for (const auto& [z0, z1] : spans[2]) boxes.push_back({{x0, y0, z0}, {x1, y1, z1}});
  return boxes;
}

}  // namespace copepod::fluid
