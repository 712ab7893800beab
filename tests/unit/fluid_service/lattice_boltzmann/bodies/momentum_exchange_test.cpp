#include "lattice_boltzmann/bodies/momentum_exchange.hpp"

#include <bit>
#include <functional>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "lattice_boltzmann/kernel/link_formula.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"
#include "surface_listing.hpp"

namespace copepod::fluid {
namespace {

/// A sphere or capsule in a box on one rank, and populations at hand.
struct Box16 {
  explicit Box16(Shape shape = {ShapeKind::sphere, 3.3, 0.0}, BoundaryKind boundary = BoundaryKind::periodic,
                 const std::vector<Shape>& others = {}) {
    setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
    setup.domain_cells = {16, 16, 16};
    for (Boundary& face : setup.boundaries) face.kind = boundary;
    setup.bodies = {shape};
    setup.bodies.insert(setup.bodies.end(), others.begin(), others.end());
    units.emplace(setup);
    domain.emplace(setup, *units);
    layout.emplace(domain->box(), 8, origin_rule(*domain, domain->box()));
    std::vector<LatticeBody> bodies;
    for (const Shape& each : setup.bodies) bodies.emplace_back(each, setup.cell_size_m);
    map.emplace(*domain, *layout, std::move(bodies));
    links.emplace(*map, *layout, true);
    populations.resize(static_cast<std::size_t>(layout->values()));
    body().position = {8.2, 7.9, 8.1};
    move();
  }

  LatticeBody& body() { return map->bodies()[0]; }
  void move() {
    map->update();
    map->accept_fresh_cells();
    links->update();
  }

  double& f(const Cell& cell, int alpha) {
    return populations[static_cast<std::size_t>(layout->location(layout->site(cell), alpha, Placement::home))];
  }
  /// The same equilibrium everywhere.
  void flow(double excess_density, const Eigen::Vector3d& u) {
    const double velocity[3] = {u[0], u[1], u[2]};
    for (std::int64_t x = 0; x < 16; ++x)
      for (std::int64_t y = 0; y < 16; ++y)
        for (std::int64_t z = 0; z < 16; ++z)
          for (int alpha = 0; alpha < d3q19::directions; ++alpha)
            f({x, y, z}, alpha) = equilibrium_deviation(alpha, excess_density, velocity);
  }

  void exchange(MovingBoundary formula = MovingBoundary::bounce_back) { exchange(*links, formula); }
  /// With the cells of these links.
  void exchange(const BoundaryLinks<double>& cells, MovingBoundary formula = MovingBoundary::bounce_back) {
    all_sums.assign(setup.bodies.size(), {});
    BoundaryLinks<double> of_cells = copy_of(cells, formula != MovingBoundary::bounce_back);
    of_cells.fetch(populations.data(), Placement::home);
    const auto collision = collision_constants<double>(CollisionKind::trt, 0.6, Eigen::Vector3d::Zero());
    const auto exchange_momentum = make_momentum_exchange(formula, collision, *layout, *map, films);
    (*exchange_momentum)(std::array{0}, of_cells, std::array{0.0}, all_sums, kept_back);
    sums = all_sums[0];
    returned = populations;
    const RowsBesideBodies<double> rows = of_cells.rows();
    for (std::int64_t row = 0; row < 16 * 16; ++row)
      for (std::uint32_t i = rows.rows[row].first_link; i < rows.rows[row].first_link + rows.rows[row].links; ++i) {
        const int leaving = static_cast<int>(direction_of(rows.links[i]));
        const Site site = layout->site(row / 16, row % 16, z_of(rows.links[i]));
        returned[static_cast<std::size_t>(layout->location(site, leaving, Placement::streamed))] =
            rows.by_link[BoundaryValues<double>::per_link(rows.second_cells) * i];
      }
  }
  /// As a formula needs them.
  [[nodiscard]] BoundaryLinks<double> copy_of(const BoundaryLinks<double>& cells, bool with_second_cells) const {
    BoundaryLinks<double> copy(*map, *layout, with_second_cells);
    for (std::size_t b = 0; b < setup.bodies.size(); ++b)
      for (const auto& [index, cell, directions, second_cells] : listing(cells.of_body(b), *layout))
        copy.set(static_cast<std::int32_t>(b), cell, directions, second_cells);
    return copy;
  }
  /// With links of one cell only.
  void exchange(const Cell& cell, std::uint32_t directions, MovingBoundary formula = MovingBoundary::bounce_back,
                std::uint32_t second_cells = 0) {
    BoundaryLinks<double> of_cell(*map, *layout, true);
    of_cell.set(0, cell, directions, second_cells);
    exchange(of_cell, formula);
  }
  /// f_ᾱ after the exchange, where the update reads it.
  [[nodiscard]] double returning(const Cell& cell, int alpha) const {
    return returned[static_cast<std::size_t>(
        layout->entry(layout->site(cell), d3q19::opposite(alpha), Placement::home))];
  }
  /// A cell's second cells in the links of the body.
  [[nodiscard]] std::uint32_t second_cells(const Cell& cell) const {
    for (const auto& [index, place, directions, second_cells] : listing(links->of_body(0), *layout))
      if (place == cell) return second_cells;
    ADD_FAILURE() << "not a boundary cell";
    return 0;
  }
  [[nodiscard]] Eigen::Vector3d force(std::size_t of = 0) const { return vector(all_sums[of], 0); }
  [[nodiscard]] Eigen::Vector3d torque(std::size_t of = 0) const { return vector(all_sums[of], 3); }
  static Eigen::Vector3d vector(const LoadSums& of, std::size_t first) {
    return {fixed_point::to_double(of[first]), fixed_point::to_double(of[first + 1]),
            fixed_point::to_double(of[first + 2])};
  }

  FluidSetup setup;
  std::optional<LatticeUnits> units;
  std::optional<Domain> domain;
  std::optional<PopulationLayout> layout;
  std::optional<MapOfAll> map;
  std::optional<BoundaryLinks<double>> links;
  std::vector<double> populations;
  std::vector<double> returned;  ///< populations with what the body sends back
  ThinFilms films{FluidSetup{}};
  std::vector<LoadSums> all_sums;
  LoadSums sums{};  ///< of the first body
  MomentumSums kept_back{};
};

// One cell at (12, 8, 8), r = (4.3, 0.6, 0.4) from the centre, with one link along −x.
TEST(MomentumExchange, OfOneLinkIsTwiceThePopulationThatIsReflected) {
  Box16 box;
  const Cell cell = {12, 8, 8};
  const int to_body = d3q19::index_of({-1, 0, 0});
  box.f(cell, to_body) = 0.25;
  box.exchange(cell, 1U << to_body);
  const Eigen::Vector3d force(-0.5, 0.0, 0.0);
  EXPECT_LT((box.force() - force).norm(), 1e-14);
  EXPECT_LT((box.torque() - Eigen::Vector3d(4.3, 0.6, 0.4).cross(force)).norm(), 1e-14);
  EXPECT_EQ(box.returning(cell, to_body), 0.25);
}

TEST(MomentumExchange, LeavesThinFilmsOutOfTheLoadsButNotOutOfTheFlow) {
  Box16 box({ShapeKind::sphere, 3.3, 0.0}, BoundaryKind::no_slip);
  box.setup.film_thickness_m = 2.5;  // resolved from 3 m on
  box.films = ThinFilms(box.setup);
  box.body().position = {8.5, 8.5, 4.8};
  box.move();
  Kinematics kinematics;
  kinematics.resize(1);
  kinematics.position_m.col(0) = box.body().position;
  kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(1, 0, 0, 0);
  box.films.find({0}, kinematics);
  const Cell below = {8, 8, 1};
  const int up = d3q19::index_of({0, 0, 1});
  box.f(below, up) = 0.25;
  box.exchange(below, 1U << up);
  EXPECT_EQ(box.force().norm(), 0.0);
  EXPECT_EQ(box.returning(below, up), 0.25);
  const Cell above = {8, 8, 8};
  const int down = d3q19::opposite(up);
  box.f(above, down) = 0.25;
  box.exchange(above, 1U << down);
  EXPECT_NEAR(box.force().z(), -0.5, 1e-14);
}

// One sphere at z = 4.8, the other beyond the periodic face at z = −2.9; a link between them, from the cell at z = 0.5.
TEST(MomentumExchange, SharesWhatAFilmLeavesOutBetweenTheTwoBodies) {
  Box16 box({ShapeKind::sphere, 3.3, 0.0}, BoundaryKind::periodic, {{ShapeKind::sphere, 3.3, 0.0}});
  box.setup.film_thickness_m = 2.5;
  box.films = ThinFilms(box.setup);
  Kinematics kinematics;
  kinematics.resize(2);
  kinematics.position_m << 8.5, 9.5, 8.5, 8.5, 4.8, 13.1;
  kinematics.orientation_wxyz << 1, 1, 0, 0, 0, 0, 0, 0;
  for (int body = 0; body < 2; ++body)
    box.map->bodies()[static_cast<std::size_t>(body)].position = kinematics.position_m.col(body);
  box.move();
  box.films.find({0, 1}, kinematics);
  const Cell cell = {8, 8, 0};
  const int up = d3q19::index_of({0, 1, 1});
  box.f(cell, up) = 0.25;
  box.exchange(cell, 1U << up);
  const Eigen::Vector3d half(0.0, 0.25, 0.25);
  EXPECT_LT((box.force(0) - half).norm() + (box.force(1) - half).norm(), 1e-14);
  EXPECT_LT((box.torque(0) - Eigen::Vector3d(0.0, 0.0, -4.3).cross(half)).norm(), 1e-14);
  EXPECT_LT((box.torque(1) - Eigen::Vector3d(-1.0, 0.0, 3.4).cross(half)).norm(), 1e-14);
}

TEST(ThinFilms, AreNotBetweenBodiesThatOverlapAtAJointWhicheverBodiesAreLookedAt) {
  FluidSetup setup;
  setup.cell_size_m = 1.0;
  setup.film_thickness_m = 1.5;
  setup.domain_cells = {40, 40, 40};
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::periodic;
  setup.bodies.assign(3, {ShapeKind::sphere, 3.0, 0.0});
  setup.jointed = {{1, 2}};
  Kinematics kinematics;
  kinematics.resize(2);
  kinematics.position_m << 0, 5, 0, 0, 0, 0;
  kinematics.orientation_wxyz << 1, 1, 0, 0, 0, 0, 0, 0;
  ThinFilms films(setup);
  films.find({0, 1}, kinematics);
  EXPECT_FALSE(films.beside(0).surfaces.empty() || films.beside(1).surfaces.empty());
  films.find({1, 2}, kinematics);
  EXPECT_TRUE(films.beside(1).surfaces.empty() && films.beside(2).surfaces.empty());
}

// Two bodies beside each other and a wall, or a mirror; films are thick, the flow is any, and cells have 2 m.
TEST(MomentumExchange, HasTheBitsOfSingleLinksInFilms) {
  const Shape sphere{ShapeKind::sphere, 2.3, 0.0}, capsule{ShapeKind::capsule, 1.7, 1.5},
      ellipsoid{.kind = ShapeKind::ellipsoid, .radius_m = 2.7, .extents_m = {1.9, 2.7, 2.4}};
  for (const Shape& shape : {sphere, capsule, ellipsoid})
    for (const BoundaryKind boundary : {BoundaryKind::no_slip, BoundaryKind::free_slip})
      for (const double thickness_m : {2.0, 4.9}) {
        Box16 box(shape, boundary, {shape});
        FluidSetup setup = box.setup;
        setup.cell_size_m = 2.0;
        setup.film_thickness_m = 2.0 * thickness_m;
        for (Shape& each : setup.bodies)
          each = {each.kind, 2.0 * each.radius_m, 2.0 * each.length_m, 2.0 * each.extents_m};
        box.films = ThinFilms(setup);
        Kinematics kinematics;
        kinematics.resize(2);
        kinematics.position_m << 10.2, 20.6, 15.8, 17.2, 9.0, 10.8;
        kinematics.orientation_wxyz << 1, 0.6, 0, -0.5, 0, 0.2, 0, 0.3;
        kinematics.orientation_wxyz.col(1).normalize();
        for (int b = 0; b < 2; ++b) {
          LatticeBody& body = box.map->bodies()[static_cast<std::size_t>(b)];
          const Eigen::Vector4d q = kinematics.orientation_wxyz.col(b);
          body.place(0.5 * kinematics.position_m.col(b), Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
          body.velocity = {0.01, -0.02 * b, 0.015};
          body.angular_velocity = {0.002, 0.001, -0.003 * b};
        }
        box.move();
        box.films.find({0, 1}, kinematics);
        NearSurfaces surfaces(setup, FilmRange(setup).high_m);
        surfaces.find(kinematics);
        for (std::size_t b = 0; b < 2; ++b)
          for (std::size_t i = 0; i < surfaces.of_body(b).size(); ++i) {
            const Eigen::Vector3d at_m(6.2 - i, 5.8, -0.8 * b);
            EXPECT_NEAR(fluid::thickness_m(box.films.beside(b).surfaces[i], {at_m[0], at_m[1], at_m[2]}),
                        surfaces.of_body(b)[i].from(at_m).m, 1e-14);
          }
        for (std::size_t i = 0; i < box.populations.size(); ++i)
          box.populations[i] = 0.002 * std::sin(0.7 * static_cast<double>(i % 1013));
        const auto collision = collision_constants<double>(CollisionKind::trt, 0.6, Eigen::Vector3d::Zero());
        const auto compare = [&]<class Formula>(const Formula& formula) {
          constexpr std::array returned = {1e-4, -2e-4};
          BoundaryLinks<double> links = box.copy_of(*box.links, Formula::uses_second_cell);
          links.fetch(box.populations.data(), Placement::home);
          const BoundaryValues<double> before = links.values();
          std::array<LoadSums, 2> loads{}, expected{};
          MomentumSums kept{}, expected_kept{};
          MomentumExchangeBy<Formula, double>(formula, *box.layout, *box.map, box.films)(std::array{0, 1}, links,
                                                                                         returned, loads, kept);
          const auto by_link = std::exchange(links.values(), before).by_link;
          const SingleLinks<Formula, double> single_links(formula, *box.layout, *box.map);
          for (std::size_t b = 0; b < 2; ++b)
            for (const CellGroup& group : links.of_body(b).groups)
              single_links(b, b, group, box.films.beside(b), links.values(), returned[b], expected, expected_kept);
          EXPECT_TRUE(loads == expected && kept == expected_kept && by_link == links.values().by_link);
          EXPECT_NE(by_link, before.by_link);
          const bool beside_faces = boundary == BoundaryKind::no_slip || thickness_m > 4.0;  // or mirror images
          EXPECT_TRUE(!beside_faces || expected_kept != MomentumSums{});
        };
        compare(BounceBack());
        compare(Interpolated());
        compare(CentralLinear());
        compare(Parabolic(collision));
      }
}

// e·u_w with u_w = U + Ω × r = (0.01, 0.02 · 4.3, 0) in the plane of the link, ρ_w = 1.25.
TEST(MomentumExchange, UsesTheVelocityOfTheSurfaceAndTheDensityOfTheCell) {
  Box16 box;
  const Cell cell = {12, 8, 8};
  const int alpha = d3q19::index_of({-1, 1, 0});
  box.body().velocity = {0.022, 0.0, 0.0};
  box.body().angular_velocity = {0.0, 0.0, 0.02};
  box.f(cell, 0) = 0.25;
  box.exchange(cell, 1U << alpha);
  const double e_dot_u = -(0.022 - 0.02 * 0.6) + 0.02 * 4.3;
  const double returning = -6.0 / 36.0 * 1.25 * e_dot_u;
  EXPECT_NEAR(box.returning(cell, alpha), returning, 1e-16);
  EXPECT_LT((box.force() - returning * Eigen::Vector3d(-1.0, 1.0, 0.0)).norm(), 1e-14);
}

TEST(MomentumExchange, FluidAtRestPushesABodyNowhereWhateverItsPressure) {
  Box16 box({ShapeKind::capsule, 2.7, 4.0});
  box.body().axis = Eigen::Vector3d(1.0, 2.0, 0.5).normalized();
  box.move();
  box.flow(0.02, Eigen::Vector3d::Zero());
  box.exchange();
  EXPECT_LT(box.force().norm(), 1e-13);
  EXPECT_LT(box.torque().norm(), 1e-12);
}

// One cell between the sphere and another one, or a wall: with the Couette flow of the gap in that cell, every
// formula that needs a second cell finds what that flow would send.
TEST(MomentumExchange, TakesTheFlowOfAGapForCouetteFlow) {
  for (const MovingBoundary formula :
       {MovingBoundary::interpolated, MovingBoundary::central_linear, MovingBoundary::parabolic}) {
    Box16 box({ShapeKind::sphere, 3.0, 0.0}, BoundaryKind::no_slip);
    box.body().position = {8.5, 8.5, 4.2};  // lowest point 1.2 cells above the wall: q = 0.7
    box.body().velocity = {0.0, 0.0, 0.012};
    box.move();
    const Cell cell = {8, 8, 0};
    const int up = d3q19::index_of({0, 0, 1});
    const double slope = 0.012 / 1.2;
    box.f(cell, up) = 3.0 / 18.0 * 0.5 * slope;
    box.f(cell, up + 1) = -box.f(cell, up);
    const std::uint32_t second_cells = box.second_cells(cell);
    EXPECT_EQ((second_cells >> up) & 1U, 0U);
    box.exchange(cell, 1U << up, formula, second_cells);
    EXPECT_NEAR(box.returning(cell, up), -3.0 / 18.0 * 1.5 * slope, 1e-16);
  }
}

// Both surfaces pass through the centre of the cell, or nearly so.
TEST(MomentumExchange, StaysFiniteWhereSurfacesTouchInTheCentreOfACell) {
  Box16 box({ShapeKind::sphere, 3.0, 0.0}, BoundaryKind::periodic, {{ShapeKind::sphere, 3.0, 0.0}});
  box.map->bodies()[1].position = {8.5, 8.5, 2.5};
  box.body().position = {8.5, 8.5, 8.5 + 1e-15};
  box.body().velocity = {0.0, 0.0, -0.01};
  box.move();
  const Cell cell = {8, 8, 5};
  const int up = d3q19::index_of({0, 0, 1});
  box.exchange(cell, 1U << up, MovingBoundary::central_linear, box.second_cells(cell));
  EXPECT_NEAR(box.returning(cell, up), -6.0 / 18.0 * (-0.01 + 0.5 * -0.01 / 0.1), 1e-12);
}

// The sphere moves away from a cell beside it, or towards it.
TEST(MomentumExchange, DrivesTheDensityOfACellNoFurtherThanAFlowDoes) {
  for (const MovingBoundary formula : {MovingBoundary::bounce_back, MovingBoundary::parabolic})
    for (const double excess_density : {-0.15, -0.05, 0.05, 0.15})
      for (const double speed : {-0.04, 0.04}) {
        Box16 box;
        const Cell cell = {11, 8, 8};
        box.flow(excess_density, Eigen::Vector3d::Zero());
        box.body().velocity = {speed, 0.0, 0.0};
        box.exchange(formula);
        double gain = 0.0;
        for (const auto& [index, place, directions, second_cells] : listing(box.links->of_body(0), *box.layout))
          for (std::uint32_t bits = place == cell ? directions : 0; bits != 0; bits &= bits - 1)
            gain += box.returning(cell, std::countr_zero(bits)) - box.f(cell, std::countr_zero(bits));
        if (std::abs(excess_density) > 0.1 && speed * excess_density > 0.0)
          EXPECT_NEAR(gain, 0.0, 1e-15) << excess_density;
        else
          EXPECT_GT(gain * speed, 0.0) << excess_density;
      }
}

// The sphere reaches beyond half of the box: links from both sides of the seam end in its nearest image.
TEST(MomentumExchange, OfABodyNearItsOwnImageHasTheRightArms) {
  Box16 box({ShapeKind::sphere, 7.8, 0.0});
  box.body().position = {8.0, 8.0, 8.0};
  box.move();
  for (std::size_t i = 0; i < box.populations.size(); ++i) box.populations[i] = 0.0;
  const Cell cell = {0, 8, 8};
  const int left = d3q19::index_of({-1, 0, 0});
  const int up_left = d3q19::index_of({-1, 0, 1});
  ASSERT_LT(box.domain->from_position(box.body().position, cell)[0], 0.0);
  box.f(cell, up_left) = 0.25;
  box.exchange(cell, (1U << left) | (1U << up_left));
  const Eigen::Vector3d force(-0.5, 0.0, 0.5);
  EXPECT_LT((box.force() - force).norm(), 1e-14);
  EXPECT_LT((box.torque() - Eigen::Vector3d(8.5, 0.5, 0.5).cross(force)).norm(), 1e-14);
}

// What is left is even in e_α and cancels over the closed surface.
TEST(MomentumExchange, ABodyThatMovesWithAUniformFlowFeelsNoForce) {
  const Eigen::Vector3d u(0.06, -0.048, 0.064);
  Box16 moving;
  moving.body().velocity = u;
  moving.flow(0.01, u);
  for (const auto formula : {MovingBoundary::bounce_back, MovingBoundary::central_linear, MovingBoundary::parabolic}) {
    moving.exchange(formula);
    EXPECT_LT(moving.force().norm(), 1e-13);
  }
  Box16 resting;
  resting.flow(0.01, u);
  resting.exchange();
  EXPECT_GT(resting.force().norm(), 1.0);
  EXPECT_GT(resting.force().normalized().dot(u.normalized()), 0.99);
}

/// Populations of any size, a sphere that moves and turns; with films, one at a wall and one to a smaller sphere.
Box16 stirred(double scale, bool films = false, double radius = 3.3) {
  const Shape small{ShapeKind::sphere, 2.0, 0.0};
  Box16 box({ShapeKind::sphere, radius, 0.0}, films ? BoundaryKind::no_slip : BoundaryKind::periodic,
            films ? std::vector{small} : std::vector<Shape>{});
  if (films) {
    Kinematics kinematics;
    kinematics.resize(2);
    kinematics.position_m << 8.2, 8.0, 7.9, 10.1 + radius, radius + 1.3, 5.8;
    kinematics.orientation_wxyz << 1, 1, 0, 0, 0, 0, 0, 0;
    for (std::size_t body = 0; body < 2; ++body)
      box.map->bodies()[body].position = kinematics.position_m.col(static_cast<Eigen::Index>(body));
    box.move();
    box.setup.film_thickness_m = 2.4;
    box.films = ThinFilms(box.setup);
    box.films.find({0, 1}, kinematics);
  }
  for (std::size_t i = 0; i < box.populations.size(); ++i)
    box.populations[i] = scale * std::sin(static_cast<double>(i * i % 1013));
  box.body().velocity = {0.01, -0.02, 0.013};
  box.body().angular_velocity = {0.01, 0.02, -0.01};
  return box;
}

/// Links of the box's sphere from the last cell to the first, all or a part of them.
BoundaryLinks<double> backwards(const Box16& box, const std::function<bool(std::size_t)>& chosen) {
  BoundaryLinks<double> links(*box.map, *box.layout, true);
  const std::vector<ListedCell> cells = listing(box.links->of_body(0), *box.layout);
  for (std::size_t i = cells.size(); i-- > 0;) {
    const auto& [index, cell, directions, second_cells] = cells[i];
    if (chosen(i)) links.set(0, cell, directions, second_cells);
  }
  return links;
}

TEST(MomentumExchange, AddsUpToTheSameBitsWhateverTheOrderAndTheShares) {
  for (const MovingBoundary formula : {MovingBoundary::bounce_back, MovingBoundary::parabolic}) {
    Box16 box = stirred(1e-3);
    box.exchange(formula);
    const LoadSums whole = box.sums;
    BoundaryLinks<double> all = backwards(box, [](std::size_t) { return true; });
    box.exchange(all, formula);
    EXPECT_EQ(box.sums, whole);
    LoadSums parts{};
    for (const bool third : {false, true}) {
      BoundaryLinks<double> part = backwards(box, [&](std::size_t i) { return (i % 3 == 0) == third; });
      box.exchange(part, formula);
      for (std::size_t i = 0; i < parts.size(); ++i) parts[i] += box.sums[i];
    }
    EXPECT_EQ(parts, whole);
  }
}

// A capsule without length is a sphere whose links are computed one by one. Some numbers of 0.15 and all of 1.5 are too
// large for eight at once.
TEST(MomentumExchange, OfEightCellsAtOnceHasTheBitsOfOneByOne) {
  for (const MovingBoundary formula : {MovingBoundary::bounce_back, MovingBoundary::interpolated,
                                       MovingBoundary::central_linear, MovingBoundary::parabolic})
    for (const auto& [scale, films, radius] : {std::tuple{1e-3, false, 3.3},
                                               {0.15, false, 3.3},
                                               {0.5, false, 3.3},
                                               {1e-3, true, 3.3},
                                               {1e-3, true, 1.6},
                                               {1e-3, true, 1.2}}) {
      Box16 box = stirred(scale, films, radius);
      box.exchange(formula);
      const std::vector<LoadSums> at_once = box.all_sums;
      const MomentumSums kept_back = box.kept_back;
      const std::vector<double> returned = box.returned;
      box.body().kind = ShapeKind::capsule;
      box.kept_back = {};
      box.exchange(formula);
      EXPECT_EQ(box.all_sums, at_once) << scale;
      EXPECT_EQ(box.kept_back, kept_back) << scale;
      EXPECT_EQ(box.returned, returned) << scale;
    }
}

TEST(MomentumExchange, NamesTheCellWhereTheFlowDiverged) {
  Box16 box;
  const auto& cell = box.links->of_body(0).groups[0].cell;
  for (int alpha = 1; alpha < d3q19::directions; ++alpha)
    box.f({cell[0][0], cell[1][0], cell[2][0]}, alpha) = std::nan("");
  EXPECT_THROW(box.exchange(), SolverError);
}

}  // namespace
}  // namespace copepod::fluid
