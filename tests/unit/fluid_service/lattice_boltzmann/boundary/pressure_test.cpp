
#include <vector>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/open_faces.hpp"
#include "lattice_boltzmann/boundary/wall.hpp"

namespace copepod::fluid {
namespace {

constexpr int up = 5;  ///< the direction +z, which enters through the low face of z

FluidSetup open_ends(double wall_velocity) {
  FluidSetup setup;
  setup.cell_size_m = setup.step_s = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  setup.domain_cells = {3, 6, 6};
  setup.boundaries[0].kind = setup.boundaries[1].kind = BoundaryKind::periodic;
  setup.boundaries[3].kind = BoundaryKind::velocity;
  setup.boundaries[3].velocity_m_per_s = {0.0, 0.0, wall_velocity};
  setup.boundaries[4].kind = setup.boundaries[5].kind = BoundaryKind::pressure;
  return setup;
}

/// Fluid at rest between open faces normal to z at its own pressure; the high face of y slides along z.
struct OpenEnds {
  explicit OpenEnds(double wall_velocity) : setup(open_ends(wall_velocity)), pressure(domain, layout) {}

  void act() {
    pressure.for_each_entering(
        populations.data(), Placement::home, [](std::int64_t) { return false; },
        [this](std::int64_t place, double value) { populations[static_cast<std::size_t>(place)] = value; });
    MovingWalls(domain, layout).apply(populations.data(), Placement::home);
  }

  [[nodiscard]] double entering(const Cell& cell) const {
    return populations[static_cast<std::size_t>(layout.entry(layout.site(cell), up, Placement::home))];
  }
  double& leaving(const Cell& cell, int alpha) {
    return populations[static_cast<std::size_t>(layout.location(layout.site(cell), alpha, Placement::home))];
  }

  FluidSetup setup;
  LatticeUnits units{setup};
  Domain domain{setup, units};
  PopulationLayout layout{domain.box(), sizeof(double), origin_rule(domain, domain.box())};
  std::vector<double> populations = std::vector<double>(static_cast<std::size_t>(layout.values()));
  OpenFaces pressure;
};

TEST(PressureFace, LetsNothingIntoFluidAtRestBesideASlidingWall) {
  OpenEnds ends(0.1);
  ends.act();
  EXPECT_EQ(ends.entering({1, 5, 0}), 0.0);
}

// In a uniform flow it is what leaves, but for the density.
TEST(PressureFace, LetsAUniformFlowContinue) {
  const Cell cell = {1, 3, 0};
  OpenEnds ends(0.0);
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    ends.leaving(cell, alpha) = equilibrium_deviation(alpha, 0.01, {0.0, 0.0, 0.05});
  const double expected = equilibrium_deviation(up, 0.01, {0.0, 0.0, 0.05}) - 0.02 * d3q19::weight(up);
  ends.act();
  EXPECT_NEAR(ends.entering(cell), expected, 1e-16);
}

// With one layer of cells beside the face, x_f − n is another rank's.
TEST(PressureFace, NeedsTwoLayersOfCellsOfARank) {
  const FluidSetup setup = open_ends(0.0);
  const LatticeUnits units(setup);
  const Domain domain(setup, units);
  const auto faces_of = [&](const Box& block) {
    const PopulationLayout layout(block, sizeof(double), origin_rule(domain, block));
    return OpenFaces(domain, layout);
  };
  EXPECT_THROW(faces_of({{0, 0, 0}, {3, 6, 1}}), CaseError);
  EXPECT_FALSE(faces_of({{0, 0, 0}, {3, 6, 2}}).empty());
  EXPECT_TRUE(faces_of({{0, 0, 2}, {3, 6, 3}}).empty());
}

// Where a body covers the cell beside, the cell at the face takes its place.
TEST(PressureFace, DoesNotContinueWhatBodiesCover) {
  OpenEnds ends(0.0);
  const Cell cell = {1, 3, 0};
  const int aslant = d3q19::index_of({0, 1, 1});
  ends.leaving({1, 2, 0}, aslant) = 0.01;  // of the cell beside
  ends.leaving(cell, aslant) = 0.02;
  const auto entering = [&](bool is_solid) {
    OpenEnds each = ends;
    OpenFaces faces(each.domain, each.layout);
    faces.for_each_entering(
        each.populations.data(), Placement::home, [is_solid](std::int64_t) { return is_solid; },
        [&each](std::int64_t place, double value) { each.populations[static_cast<std::size_t>(place)] = value; });
    return each
        .populations[static_cast<std::size_t>(each.layout.entry(each.layout.site(cell), aslant, Placement::home))];
  };
  EXPECT_NEAR(entering(false), 0.01 - 0.02 * 2.0 / 36.0, 1e-15);
  EXPECT_NEAR(entering(true), 0.02 - 0.02 * 2.0 / 36.0, 1e-15);
}

}  // namespace
}  // namespace copepod::fluid
