#include "lattice_boltzmann/bodies/body_map.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "lattice_boltzmann/bodies/boundary_links.hpp"
#include "lattice_boltzmann/bodies/nearby_bodies.hpp"
#include "ranks/block_partition.hpp"
#include "surface_listing.hpp"
#include "voxel_shape.hpp"

namespace copepod::fluid {
namespace {

FluidSetup periodic_box(const Cell& cells, std::vector<Shape> bodies) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.domain_cells = cells;
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::periodic;
  setup.bodies = std::move(bodies);
  return setup;
}

/// A map over a whole box on one rank, or over the block of one of several.
struct MapFixture {
  explicit MapFixture(const FluidSetup& setup, int ranks = 1, int rank = 0)
      : units(setup),
        domain(setup, units),
        layout(BlockPartition(domain.cells(), ranks).block(rank), 8),
        map(domain, layout, bodies_of(setup)) {}

  static std::vector<LatticeBody> bodies_of(const FluidSetup& setup) {
    std::vector<LatticeBody> bodies;
    for (const Shape& shape : setup.bodies) bodies.emplace_back(shape, setup.cell_size_m);
    return bodies;
  }
  std::int64_t covered(std::int32_t body) const {
    std::int64_t count = 0;
    for (std::int64_t x = 0; x < domain.cells()[0]; ++x)
      for (std::int64_t y = 0; y < domain.cells()[1]; ++y)
        for (std::int64_t z = 0; z < domain.cells()[2]; ++z)
          if (map.owner(layout.cell(Cell{x, y, z})) == body + 1) ++count;
    return count;
  }

  LatticeUnits units;
  Domain domain;
  PopulationLayout layout;
  MapOfAll map;
};

TEST(BodyMap, CoversTheCellsWhoseCentresLieInside) {
  MapFixture fixture(periodic_box({20, 20, 20}, {{ShapeKind::sphere, 4.0, 0.0}}));
  fixture.map.bodies()[0].position = {10.2, 9.7, 10.1};
  EXPECT_TRUE(fixture.map.update());
  std::int64_t expected = 0;
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y)
      for (int z = 0; z < 20; ++z)
        if (std::hypot(x + 0.5 - 10.2, y + 0.5 - 9.7, z + 0.5 - 10.1) < 4.0) ++expected;
  EXPECT_EQ(fixture.covered(0), expected);
}

TEST(BodyMap, VolumeOfATiltedCapsuleIsRight) {
  MapFixture fixture(periodic_box({40, 40, 40}, {{ShapeKind::capsule, 6.0, 12.0}}));
  fixture.map.bodies()[0].position = {20.0, 20.0, 20.0};
  fixture.map.bodies()[0].axis = Eigen::Vector3d(1.0, 2.0, 3.0).normalized();
  fixture.map.update();
  const double volume = std::numbers::pi * 36.0 * (12.0 + 8.0);
  EXPECT_NEAR(static_cast<double>(fixture.covered(0)) / volume, 1.0, 0.02);
}

TEST(BodyMap, BodyThatCrossesAPeriodicFaceKeepsItsVolume) {
  MapFixture inside(periodic_box({16, 16, 16}, {{ShapeKind::sphere, 3.3, 0.0}}));
  MapFixture across(periodic_box({16, 16, 16}, {{ShapeKind::sphere, 3.3, 0.0}}));
  inside.map.bodies()[0].position = {8.25, 8.5, 8.125};
  across.map.bodies()[0].position = {0.25, 16.5, 24.125};
  inside.map.update();
  across.map.update();
  EXPECT_EQ(inside.covered(0), across.covered(0));
}

// Such a sphere is left out for some steps, but for none in which a centre crosses its surface: along its velocity,
// which turns, or another way.
TEST(BodyMap, SlowSphereTakesAndLosesEveryCellInTime) {
  for (const auto& [radius, step_lu, has_velocity] : {std::tuple(0.7, 6e-4, false),
                                                      {2.2, 6e-4, false},
                                                      {4.0, 6e-4, false},
                                                      {0.7, 3e-3, true},
                                                      {2.2, 2e-3, true},
                                                      {4.0, 6e-4, true}}) {
    MapFixture fixture(periodic_box({12, 12, 12}, {{ShapeKind::sphere, radius, 0.0}}));
    LatticeBody& body = fixture.map.bodies()[0];
    body.position = {6.0, 6.0, 6.0};
    for (int step = 0; step < 1000; ++step) {
      const Eigen::Vector3d way = step_lu * Eigen::Vector3d(0.9, -0.5, std::cos(0.001 * step));
      body.position += way;
      if (has_velocity) body.velocity = way;
      fixture.map.update();
      fixture.map.accept_fresh_cells();
      for (std::int64_t x = 0; x < 12; ++x)
        for (std::int64_t y = 0; y < 12; ++y)
          for (std::int64_t z = 0; z < 12; ++z) {
            const Eigen::Vector3d r = Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(0.5) - body.position;
            const Eigen::Vector3d image = 12.0 * (r / 12.0).array().round();
            const std::int32_t owner = fixture.map.owner(fixture.layout.cell(Cell{x, y, z}));
            ASSERT_EQ(owner, (r - image).norm() < radius ? 1 : 0)
                << "step " << step << ", " << x << " " << y << " " << z;
          }
    }
  }
}

TEST(BodyMap, FollowsABodyThatTurnsInItsPlaceAboutItsZAxis) {
  const Shape shapes[] = {{.kind = ShapeKind::ellipsoid, .radius_m = 3.0, .extents_m = {2.0, 5.0, 3.0}},
                          {.kind = ShapeKind::box, .radius_m = 3.0, .extents_m = {4.0, 9.0, 6.0}}};
  for (const Shape& shape : shapes) {
    MapFixture fixture(periodic_box({20, 20, 20}, {shape}));
    LatticeBody& body = fixture.map.bodies()[0];
    body.place({10.0, 10.0, 10.0}, Eigen::Quaterniond::Identity());
    fixture.map.update();
    body.place({10.0, 10.0, 10.0}, Eigen::Quaterniond::Identity());
    EXPECT_FALSE(fixture.map.update());
    body.place({10.0, 10.0, 10.0}, Eigen::Quaterniond(0.6, 0.0, 0.0, 0.8));
    EXPECT_TRUE(fixture.map.update());
  }
}

TEST(BodyMap, ListsUncoveredCellsWithTheBodyThatLeft) {
  MapFixture fixture(periodic_box({20, 20, 20}, {{ShapeKind::sphere, 4.0, 0.0}}));
  fixture.map.bodies()[0].position = {10.0, 10.0, 10.0};
  fixture.map.update();
  const std::int64_t before = fixture.covered(0);
  fixture.map.bodies()[0].position = {11.0, 10.0, 10.0};
  fixture.map.update();
  EXPECT_EQ(fixture.covered(0), before);  // a whole cell further: the same picture
  EXPECT_FALSE(fixture.map.uncovered().empty());
  for (const auto& uncovered : fixture.map.uncovered()) {
    EXPECT_EQ(uncovered.body, 0);
    EXPECT_EQ(fixture.map.owner(fixture.layout.cell(uncovered.cell())), BodyMap::fresh);
  }
}

TEST(BodyMap, NamesABodyThatLeavesAWalledDomain) {
  FluidSetup setup = periodic_box({20, 20, 20}, {{ShapeKind::sphere, 4.0, 0.0}});
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::no_slip;
  MapFixture fixture(setup);
  fixture.map.bodies()[0].position = {10.0, 10.0, 20.5};
  EXPECT_THROW(fixture.map.update(), SolverError);
}

/// Whether a body of radius 4 that moves from the middle to `position` is refused.
bool is_refused(const FluidSetup& setup, const Eigen::Vector3d& position) {
  MapFixture fixture(setup);
  fixture.map.bodies()[0].position = {10.0, 10.0, 10.0};
  fixture.map.update();
  fixture.map.bodies()[0].position = position;
  try {
    fixture.map.update();
    return false;
  } catch (const SolverError&) {
    return true;
  }
}

TEST(BodyMap, RefusesABodyThatRunsIntoAFace) {
  FluidSetup setup = periodic_box({20, 20, 40}, {{ShapeKind::sphere, 4.0, 0.0}});
  setup.boundaries[face_index(0, false)].kind = setup.boundaries[face_index(0, true)].kind = BoundaryKind::no_slip;
  setup.boundaries[face_index(1, false)].kind = setup.boundaries[face_index(1, true)].kind = BoundaryKind::free_slip;
  setup.symmetry_planes[2] = true;
  EXPECT_FALSE(is_refused(setup, {4.01, 10.0, 10.0}));
  EXPECT_TRUE(is_refused(setup, {3.99, 10.0, 10.0}));
  EXPECT_FALSE(is_refused(setup, {15.99, 10.0, 10.0}));
  EXPECT_TRUE(is_refused(setup, {16.01, 10.0, 10.0}));
  EXPECT_FALSE(is_refused(setup, {10.0, 4.01, 10.0}));  // beyond a mirror is the body's image
  EXPECT_TRUE(is_refused(setup, {10.0, 3.99, 10.0}));
  EXPECT_FALSE(is_refused(setup, {10.0, 10.0, 15.99}));
  EXPECT_TRUE(is_refused(setup, {10.0, 10.0, 16.01}));
  EXPECT_FALSE(is_refused(setup, {10.0, 10.0, 20.0}));  // on the plane, which cuts it
}

TEST(BodyMap, LetsABodyReachBeyondAFaceByTheOverlapOfContacts) {
  FluidSetup setup = periodic_box({20, 20, 40}, {{ShapeKind::sphere, 4.0, 0.0}});
  setup.boundaries[face_index(0, false)].kind = setup.boundaries[face_index(0, true)].kind = BoundaryKind::no_slip;
  setup.wall_overlap_m = 0.25;
  EXPECT_FALSE(is_refused(setup, {3.76, 10.0, 10.0}));
  EXPECT_TRUE(is_refused(setup, {3.74, 10.0, 10.0}));
  EXPECT_FALSE(is_refused(setup, {16.24, 10.0, 10.0}));
  EXPECT_TRUE(is_refused(setup, {16.26, 10.0, 10.0}));
}

TEST(BodyMap, LetsABodyThatRestsStandInAWall) {
  FluidSetup setup = periodic_box({20, 20, 20}, {{ShapeKind::sphere, 4.0, 0.0}});
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::no_slip;
  MapFixture fixture(setup);
  fixture.map.bodies()[0].position = {10.0, 10.0, 0.0};
  EXPECT_TRUE(fixture.map.update());
  EXPECT_FALSE(fixture.map.update());
}

/// Links are kept up to date around changed cells only: they must equal those of a map made from scratch,
/// also where bodies touch or overlap.
/// @param height_B  of the second one; the first is at 9
void expect_links_of_passing_spheres(double height_B) {
  SCOPED_TRACE(height_B);
  const FluidSetup setup = periodic_box({18, 18, 18}, {{ShapeKind::sphere, 3.0, 0.0}, {ShapeKind::sphere, 3.0, 0.0}});
  MapFixture incremental(setup);
  BoundaryLinks<double> links(incremental.map, incremental.layout, true);
  for (int step = 0; step < 300; ++step) {
    const double t = 0.02 * step;
    const auto place = [&](BodyMap& map) {
      map.bodies()[0].position = {5.0 + t, 9.0, 9.0};
      map.bodies()[1].position = {13.0 - t, 9.3, height_B};
    };
    place(incremental.map);
    if (incremental.map.update()) links.update();
    incremental.map.accept_fresh_cells();
    MapFixture fresh(setup);
    place(fresh.map);
    BoundaryLinks<double> expected(fresh.map, fresh.layout, true);
    fresh.map.update();
    expected.update();
    for (std::size_t body = 0; body < 2; ++body)
      ASSERT_EQ(listing(links.of_body(body), incremental.layout), listing(expected.of_body(body), fresh.layout))
          << "step " << step;
    for (std::int64_t cell = 0; cell < fresh.layout.cells(); ++cell)
      ASSERT_EQ(incremental.map.owner(cell), fresh.map.owner(cell)) << "step " << step << ", cell " << cell;
  }
}

TEST(BoundaryLinks, IncrementalLinksEqualLinksFromScratch) {
  expect_links_of_passing_spheres(15.1);  // at a distance of less than a cell
  expect_links_of_passing_spheres(14.2);  // some cells are in both
  expect_links_of_passing_spheres(10.0);  // one through the other
}

/// Bodies that cross each other and turn, inside faces that are not periodic and across those that are;
/// now and then one is given at another periodic image. The first one stays on a symmetry plane.
class CrossingBodies {
 public:
  CrossingBodies(const FluidSetup& setup, const Domain& domain, unsigned seed) : domain_(domain), random_(seed) {
    for (const Shape& shape : setup.bodies) {
      Way way;
      for (int axis = 0; axis < 3; ++axis) {
        const double reach = bounding_radius_m(shape) + 1e-6;
        const auto cells = static_cast<double>(domain.cells()[axis]);
        const bool on_plane = domain.symmetric(axis) && ways_.empty();
        way.middle[axis] = domain.periodic(axis) ? uniform(0.0, cells) : 0.5 * cells;
        way.amplitude[axis] = domain.periodic(axis) ? uniform(2.0, 30.0) : uniform(0.5, 1.0) * (0.5 * cells - reach);
        if (on_plane) way.middle[axis] = cells, way.amplitude[axis] = 0.0;
        for (Eigen::Vector3d* const each : {&way.rate, &way.phase, &way.spin})
          (*each)[axis] = uniform(-1.0, 1.0) * (each == &way.phase ? 3.0 : 0.05);
      }
      ways_.push_back(way);
    }
  }
  void move(int step) {
    places_.clear();
    for (const Way& way : ways_) {
      auto& [position, orientation] = places_.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        position[axis] = way.middle[axis] + way.amplitude[axis] * std::sin(way.rate[axis] * step + way.phase[axis]);
        if (domain_.periodic(axis) && uniform(0.0, 1.0) < 0.02)
          position[axis] += static_cast<double>(domain_.cells()[axis]);
      }
      orientation.setFromTwoVectors(Eigen::Vector3d::UnitZ(),
                                    Eigen::Vector3d(1.0, std::sin(way.spin[0] * step), std::cos(way.spin[1] * step)));
    }
  }
  void place(std::vector<LatticeBody>& bodies) const {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const auto& [position, orientation] = places_[b];
      if (bodies[b].kind == ShapeKind::sphere)
        bodies[b].position = position;
      else
        bodies[b].place(position, orientation);
    }
  }

 private:
  struct Way {
    Eigen::Vector3d middle, amplitude, rate, phase, spin;
  };
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }

  const Domain& domain_;
  std::mt19937 random_;
  std::vector<Way> ways_;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Quaterniond>> places_;
};

/// Covered and uncovered cells must be those that the owners before and after imply, and where they differ both must be
/// among the changed ones.
void expect_lists_of(const BodyMap& map, const std::vector<std::int32_t>& before, const PopulationLayout& layout) {
  using Listed = std::set<std::pair<std::int64_t, std::int32_t>>;
  const auto listed = [&](const std::vector<BodyMap::ChangedCell>& cells) {
    Listed result;
    for (const BodyMap::ChangedCell& c : cells) result.emplace(layout.cell(c.cell()), c.body);
    return result;
  };
  const Listed changed = listed(map.changed());
  Listed covered, uncovered;
  for (std::int64_t cell = 0; cell < layout.cells(); ++cell) {
    const std::int32_t was = before[static_cast<std::size_t>(cell)];
    const std::int32_t is = std::max(map.owner(cell), BodyMap::fluid);
    if (was == is) continue;
    if (was == BodyMap::fluid) covered.emplace(cell, is - 1);
    if (is == BodyMap::fluid) uncovered.emplace(cell, was - 1);
    for (const std::int32_t owner : {was, is})
      EXPECT_TRUE(owner == BodyMap::fluid || changed.contains({cell, owner - 1})) << "cell " << cell;
  }
  EXPECT_EQ(listed(map.covered()), covered);
  EXPECT_EQ(listed(map.uncovered()), uncovered);
  EXPECT_EQ(map.covered().size(), covered.size());
  EXPECT_EQ(map.uncovered().size(), uncovered.size());
}

/// Owners, lists and links of the blocks of so many ranks, each of which gets the bodies near its block only.
void expect_map_from_scratch(const FluidSetup& setup, int ranks, unsigned seed) {
  SCOPED_TRACE(std::to_string(ranks) + " ranks, seed " + std::to_string(seed));
  std::vector<std::unique_ptr<MapFixture>> fixtures;
  std::vector<std::unique_ptr<BoundaryLinks<double>>> links;
  for (int rank = 0; rank < ranks; ++rank) {
    fixtures.push_back(std::make_unique<MapFixture>(setup, ranks, rank));
    links.push_back(std::make_unique<BoundaryLinks<double>>(fixtures.back()->map, fixtures.back()->layout, true));
  }
  const Domain& domain = fixtures[0]->domain;
  const BlockPartition partition(domain.cells(), ranks);
  const NearBlocks near_blocks(domain, partition, 0.0);
  CrossingBodies crossing(setup, domain, seed);
  std::vector<std::set<std::int32_t>> were_near(static_cast<std::size_t>(ranks));
  for (int step = 0; step < 100; ++step) {
    crossing.move(step);
    std::vector<std::set<std::int32_t>> near(static_cast<std::size_t>(ranks));
    std::vector<LatticeBody> bodies = fixtures[0]->map.bodies();
    crossing.place(bodies);
    for (std::size_t b = 0; b < bodies.size(); ++b)
      near_blocks.for_each_rank(
          near_blocks.around(bodies[b].position, bounding_radius_m(setup.bodies[b])).blocks, {},
          [&](int rank) { near[static_cast<std::size_t>(rank)].insert(static_cast<std::int32_t>(b)); });
    for (int rank = 0; rank < ranks; ++rank) {
      const auto r = static_cast<std::size_t>(rank);
      MapFixture& fixture = *fixtures[r];
      std::set<std::int32_t> listed = near[r];
      listed.merge(were_near[r]);
      std::vector<std::int32_t> before;
      for (std::int64_t cell = 0; cell < fixture.layout.cells(); ++cell) before.push_back(fixture.map.owner(cell));
      crossing.place(fixture.map.bodies());
      if (fixture.map.update(std::vector(listed.begin(), listed.end()))) links[r]->update();
      if (step > 0) expect_lists_of(fixture.map, before, fixture.layout);
      fixture.map.accept_fresh_cells();
      MapFixture fresh(setup, ranks, rank);
      BoundaryLinks<double> fresh_links(fresh.map, fresh.layout, true);
      crossing.place(fresh.map.bodies());
      if (fresh.map.update()) fresh_links.update();
      for (std::int64_t cell = 0; cell < fresh.layout.cells(); ++cell)
        ASSERT_EQ(fixture.map.owner(cell), fresh.map.owner(cell)) << "step " << step << ", cell " << cell;
      for (std::size_t b = 0; b < bodies.size(); ++b)
        ASSERT_EQ(listing(links[r]->of_body(b), fixture.layout), listing(fresh_links.of_body(b), fresh.layout))
            << "step " << step << ", body " << b;
    }
    were_near = near;
  }
}

// What is kept from step to step only saves time, where bodies overlap as where they do not, and where one crosses its
// own image.
TEST(BodyMap, OfBodiesThatCrossEqualsOneMadeFromScratch) {
  const Shape box{.kind = ShapeKind::box, .extents_m = {3.0, 4.0, 5.0}};
  const std::vector<std::array<int, 3>> angle = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  const std::vector<Shape> bodies = {
      {ShapeKind::sphere, 3.0, 0.0},
      {ShapeKind::capsule, 2.0, 5.0},
      doubles::voxel_shape(angle, 1.7, {1.5, 0.8, 0.5}),
      {ShapeKind::sphere, 3.5, 0.0},
      {.kind = ShapeKind::ellipsoid, .radius_m = 2.0, .extents_m = {1.5, 3.0, 4.0}},
      {ShapeKind::capsule, 1.5, 6.0},
      {ShapeKind::cylinder, 2.0, 5.0},
      {.kind = ShapeKind::compound, .parts = {{box, {0.0, 0.0, 1.0}}, {{ShapeKind::sphere, 2.2}, {0.0, 0.0, -1.5}}}}};
  FluidSetup periodic = periodic_box({14, 15, 16}, bodies);
  periodic.bodies.push_back({ShapeKind::capsule, 1.5, 18.0});  // meets its own image
  FluidSetup walls = periodic_box({16, 14, 15}, bodies);
  walls.boundaries[face_index(1, false)].kind = walls.boundaries[face_index(1, true)].kind = BoundaryKind::no_slip;
  FluidSetup mirrors = periodic_box({14, 13, 30}, bodies);
  mirrors.boundaries[face_index(1, false)].kind = mirrors.boundaries[face_index(1, true)].kind =
      BoundaryKind::free_slip;
  mirrors.boundaries[face_index(2, false)].kind = mirrors.boundaries[face_index(2, true)].kind = BoundaryKind::no_slip;
  mirrors.symmetry_planes[2] = true;
  unsigned seed = 1;
  for (const FluidSetup& setup : {periodic, walls, mirrors})
    for (const int ranks : {1, 2, 4}) expect_map_from_scratch(setup, ranks, seed++);
}

TEST(BoundaryLinks, EveryLinkJoinsAFluidCellAndACoveredOne) {
  MapFixture fixture(periodic_box({20, 20, 20}, {{ShapeKind::sphere, 4.0, 0.0}}));
  fixture.map.bodies()[0].position = {1.0, 10.0, 10.0};
  BoundaryLinks<double> links(fixture.map, fixture.layout, true);
  fixture.map.update();
  links.update();
  std::int64_t found = 0;
  for (const auto& [index, cell, directions, second_cells] : listing(links.of_body(0), fixture.layout)) {
    EXPECT_EQ(fixture.map.owner(index), BodyMap::fluid);
    for (int alpha = 1; alpha < d3q19::directions; ++alpha)
      if ((directions >> alpha) & 1U) {
        EXPECT_EQ(fixture.map.owner(index + fixture.layout.neighbour(alpha)), 1);
        ++found;
      }
  }
  // The same count from the solid side, through canonical cells.
  std::int64_t expected = 0;
  for (std::int64_t x = 0; x < 20; ++x)
    for (std::int64_t y = 0; y < 20; ++y)
      for (std::int64_t z = 0; z < 20; ++z) {
        if (fixture.map.owner(fixture.layout.cell(Cell{x, y, z})) != 1) continue;
        for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
          const auto& e = d3q19::e[alpha];
          const Cell neighbour = fixture.domain.canonical({x + e[0], y + e[1], z + e[2]}).value();
          if (fixture.map.owner(fixture.layout.cell(neighbour)) == BodyMap::fluid) ++expected;
        }
      }
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace copepod::fluid
