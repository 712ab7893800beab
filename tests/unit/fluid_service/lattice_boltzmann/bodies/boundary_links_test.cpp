#include "lattice_boltzmann/bodies/boundary_links.hpp"

#include <bit>
#include <cmath>

#include <gtest/gtest.h>

#include "lattice_boltzmann/kernel/exchange_group.hpp"
#include "surface_listing.hpp"

namespace copepod::fluid {
namespace {

/// Two spheres and a capsule that touch each other, and a sphere in both ends of a period, in a box that is periodic
/// along x and z and has a mirror and a wall.
struct Crowd {
  Crowd() {
    setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
    setup.domain_cells = {16, 20, 18};
    setup.boundaries[0].kind = setup.boundaries[1].kind = BoundaryKind::periodic;
    setup.boundaries[4].kind = setup.boundaries[5].kind = BoundaryKind::periodic;
    setup.boundaries[2].kind = BoundaryKind::free_slip;
    setup.bodies = {{ShapeKind::sphere, 3.1, 0.0},
                    {ShapeKind::sphere, 2.6, 0.0},
                    {ShapeKind::capsule, 2.2, 5.0},
                    {ShapeKind::sphere, 2.4, 0.0}};
    units.emplace(setup);
    domain.emplace(setup, *units);
    layout.emplace(domain->box(), 8, origin_rule(*domain, domain->box()));
    std::vector<LatticeBody> bodies;
    for (const Shape& shape : setup.bodies) bodies.emplace_back(shape, setup.cell_size_m);
    map.emplace(*domain, *layout, bodies);
    links.emplace(*map, *layout, true);
    populations.resize(static_cast<std::size_t>(layout->values()));
  }

  void place(const Eigen::Vector3d& shift) {
    map->bodies()[0].position = Eigen::Vector3d(2.1, 7.2, 8.9) + shift;
    map->bodies()[1].position = Eigen::Vector3d(7.6, 7.4, 9.1) + shift;
    map->bodies()[2].position = Eigen::Vector3d(13.2, 9.3, 8.4) + shift;
    map->bodies()[3].position = Eigen::Vector3d(8.3, 15.4, -0.4) + shift;
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
  std::optional<MapOfAll> map;
  std::optional<BoundaryLinks<double>> links;
  std::vector<double> populations;
};

TEST(BoundaryLinks, AreAllDirectionsFromFluidCellsIntoABodyWhereverItMoves) {
  Crowd crowd;
  for (int step = 0; step < 40; ++step) {
    crowd.place(Eigen::Vector3d(0.31, -0.05, 0.03) * step);
    for (std::int32_t body = 0; body < 4; ++body) {
      std::vector<std::pair<std::int64_t, std::uint32_t>> found;
      for (const auto& [index, cell, directions, second_cells] :
           listing(crowd.links->of_body(static_cast<std::size_t>(body)), *crowd.layout))
        found.emplace_back(index, directions);
      ASSERT_EQ(found, crowd.expected(body)) << "step " << step << ", body " << body;
      ASSERT_GT(found.size(), 50U);
    }
  }
}

/// visit(link's place, cell, direction) for all links of all bodies.
template <class Visit>
void for_each_link(Crowd& crowd, const Visit& visit) {
  for (std::size_t body = 0; body < 4; ++body)
    for (const CellGroup& group : crowd.links->of_body(body).groups)
      for (std::size_t lane = 0; lane < surface_lanes; ++lane) {
        std::size_t link = group.first_link[lane];
        for (std::uint32_t bits = group.directions[lane]; bits != 0; bits &= bits - 1, ++link)
          visit(link, Cell{group.cell[0][lane], group.cell[1][lane], group.cell[2][lane]}, std::countr_zero(bits));
      }
}

// The update goes through each row once.
TEST(BoundaryLinks, AreInTheOrderOfTheirRowWhereverTheBodiesMove) {
  Crowd crowd;
  for (int step = 0; step < 40; ++step) {
    crowd.place(Eigen::Vector3d(0.31, -0.05, 0.03) * step);
    const RowsBesideBodies<double> found = crowd.links->rows();
    for (const BoundaryRow& row : std::span(found.rows, 16 * 20)) {
      const std::span links(found.links + row.first_link, row.links);
      const std::span z(found.z + row.first_cell, row.cells);
      ASSERT_TRUE(std::ranges::is_sorted(z));
      ASSERT_TRUE(std::ranges::is_sorted(links, {}, z_of));
    }
  }
}

// Whether it was fetched when the cell became a boundary cell, or collected by an update: in both placements.
TEST(BoundaryLinks, HoldThePopulationsOfTheirCellsWhereverTheBodiesMove) {
  using Values = BoundaryValues<double>;
  constexpr std::size_t per_link = Values::per_link(true);
  Crowd crowd;
  const auto constants = collision_constants<double>(CollisionKind::trt, 0.7, Eigen::Vector3d::Zero());
  for (int step = 0; step < 40; ++step) {
    const Placement placement = step % 2 == 0 ? Placement::home : Placement::streamed;
    for (std::size_t i = 0; i < crowd.populations.size(); ++i)
      crowd.populations[i] = 0.01 * std::sin(static_cast<double>(i + 7 * static_cast<std::size_t>(step)));
    const RowsBesideBodies<double> rows = crowd.links->rows();
    choose_kernels<double>().stream_collide(crowd.populations.data(), *crowd.layout, other(placement),
                                            {{0, 0, 0}, {16, 20, 18}}, constants, false, &rows);
    crowd.place(Eigen::Vector3d(0.31, -0.05, 0.03) * step);
    crowd.links->fetch(crowd.populations.data(), placement);
    const BoundaryValues<double>& found = crowd.links->values();
    for_each_link(crowd, [&](std::size_t link, const Cell& cell, int alpha) {
      const auto f = crowd.layout->gather(crowd.populations.data(), crowd.layout->site(cell), placement);
      const double* const values = found.by_link.data() + per_link * link;
      ASSERT_EQ(values[Values::crossing], f[static_cast<std::size_t>(alpha)]) << step;
      ASSERT_EQ(values[Values::inward], f[static_cast<std::size_t>(d3q19::opposite(alpha))]) << step;
      const std::int64_t enters = crowd.layout->entry(crowd.layout->site(cell), alpha, placement);
      ASSERT_EQ(values[Values::behind], crowd.populations[static_cast<std::size_t>(enters)]) << step;
    });
    const BodySurface& surface = crowd.links->of_body(0);
    for (std::size_t g = 0; g < surface.groups.size(); ++g)
      for (std::size_t lane = 0; lane < surface_lanes; ++lane) {
        const CellGroup& group = surface.groups[g];
        const double* const of_cell = found.by_cell.data() + Values::per_cell(true) * group.moments[lane];
        if (group.directions[lane] == 0) {
          ASSERT_EQ(of_cell[Values::excess_density], 0.0);
          for (std::size_t j = 0; j < group.links; ++j)
            ASSERT_EQ(found.by_link[per_link * (group.first_link[lane] + j) + Values::crossing], 0.0);
          continue;
        }
        const Site site = crowd.layout->site(group.cell[0][lane], group.cell[1][lane], group.cell[2][lane]);
        const Moments<double> m = moments(crowd.layout->gather(crowd.populations.data(), site, placement));
        ASSERT_EQ(of_cell[Values::excess_density], m.excess_density);
        for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_EQ(of_cell[Values::momentum + axis], m.momentum[axis]);
      }
  }
}

}  // namespace
}  // namespace copepod::fluid
