#include "lattice_boltzmann/bodies/boundary_links.hpp"

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

/// Two spheres and a capsule that touch each other, in a box that is periodic along x and has a mirror and
/// a wall.
struct Crowd {
  Crowd() {
    setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
    setup.domain_cells = {16, 20, 18};
    setup.boundaries[0].kind = setup.boundaries[1].kind = BoundaryKind::periodic;
    setup.boundaries[2].kind = BoundaryKind::free_slip;
    setup.bodies = {{ShapeKind::sphere, 3.1, 0.0}, {ShapeKind::sphere, 2.6, 0.0}, {ShapeKind::capsule, 2.2, 5.0}};
    units.emplace(setup);
    domain.emplace(setup, *units);
    layout.emplace(domain->box(), 8);
    std::vector<LatticeBody> bodies;
    for (const Shape& shape : setup.bodies) bodies.emplace_back(shape, *units);
    map.emplace(*domain, *layout, bodies);
    links.emplace(*map, *layout, Box{{0, 0, 0}, {16, 20, 18}});
  }

  void place(const Eigen::Vector3d& shift) {
    map->bodies()[0].position = Eigen::Vector3d(2.1, 7.2, 8.9) + shift;
    map->bodies()[1].position = Eigen::Vector3d(7.6, 7.4, 9.1) + shift;
    map->bodies()[2].position = Eigen::Vector3d(13.2, 9.3, 8.4) + shift;
    map->bodies()[2].axis = Eigen::Vector3d(1.0, 2.0, -1.0).normalized();
    map->update();
    map->accept_fresh_cells();
    links->update();
  }

  /// By definition: every direction from a fluid cell into a cell that the body covers.
  [[nodiscard]] std::vector<std::pair<std::int64_t, std::uint32_t>> expected(std::int32_t body) const {
    std::vector<std::pair<std::int64_t, std::uint32_t>> cells;
    for (std::int64_t x = 0; x < 16; ++x)
      for (std::int64_t y = 0; y < 20; ++y)
        for (std::int64_t z = 0; z < 18; ++z) {
          const std::int64_t index = layout->cell(x, y, z);
          std::uint32_t directions = 0;
          for (int alpha = 1; alpha < d3q19::directions; ++alpha)
            if (map->owner(index + layout->neighbour(alpha)) == body + 1) directions |= 1U << alpha;
          if (directions != 0 && map->owner(index) == BodyMap::fluid) cells.emplace_back(index, directions);
        }
    return cells;
  }

  FluidSetup setup;
  std::optional<LatticeUnits> units;
  std::optional<Domain> domain;
  std::optional<PopulationLayout> layout;
  std::optional<BodyMap> map;
  std::optional<BoundaryLinks> links;
};

TEST(BoundaryLinks, AreAllDirectionsFromFluidCellsIntoABodyWhereverItMoves) {
  Crowd crowd;
  for (int step = 0; step < 40; ++step) {
    crowd.place(Eigen::Vector3d(0.31, -0.05, 0.03) * step);
    for (std::int32_t body = 0; body < 3; ++body) {
      std::vector<std::pair<std::int64_t, std::uint32_t>> found;
      for (const BoundaryCell& cell : crowd.links->of_body(static_cast<std::size_t>(body))) {
        EXPECT_EQ(crowd.layout->cell(cell.position), cell.site.index);
        found.emplace_back(cell.site.index, cell.directions);
      }
      ASSERT_EQ(found, crowd.expected(body)) << "step " << step << ", body " << body;
      ASSERT_GT(found.size(), 50U);
    }
  }
}

TEST(BoundaryLinks, CellsOutsideTheInteriorBelongToTheBorder) {
  Crowd crowd;
  crowd.links.emplace(*crowd.map, *crowd.layout, Box{{1, 0, 0}, {15, 20, 18}});
  crowd.place(Eigen::Vector3d::Zero());
  int border = 0;
  for (const BoundaryCell& cell : crowd.links->of_body(0)) {
    EXPECT_EQ(cell.border, cell.position[0] == 0 || cell.position[0] == 15);
    border += cell.border ? 1 : 0;
  }
  EXPECT_GT(border, 0);
}

}  // namespace
}  // namespace copepod::fluid
