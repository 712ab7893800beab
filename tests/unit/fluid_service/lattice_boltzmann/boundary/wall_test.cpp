#include "lattice_boltzmann/boundary/wall.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "lattice_boltzmann/boundary/open_faces.hpp"
#include "lattice_boltzmann/lattice/initial_flow.hpp"

namespace copepod::fluid {
namespace {

std::vector<int> places_of(const Runs& runs, std::size_t size) {
  std::vector<int> array(size);
  for (std::size_t i = 0; i < size; ++i) array[i] = static_cast<int>(i);
  std::vector<int> places;
  runs.for_each(array.data(), [&](int place) { places.push_back(place); });
  return places;
}

TEST(Runs, PlacesOfEqualStrideAreOneRun) {
  Runs runs;
  for (int i = 0; i < 4; ++i) runs.add(10 + i);
  for (int i = 0; i < 3; ++i) runs.add(20 + 5 * i);
  for (int i = 0; i < 3; ++i) runs.add(9 - i);
  EXPECT_EQ(runs.runs().size(), 3U);
  EXPECT_EQ(runs.values(), 10);
  EXPECT_EQ(places_of(runs, 31), (std::vector<int>{10, 11, 12, 13, 20, 25, 30, 9, 8, 7}));
}

TEST(Runs, VisitPlacesInTheOrderInWhichTheyWereAdded) {
  Runs runs;
  const std::vector<int> places = {3, 3, 4, 9, 1, 7, 0};
  for (const int place : places) runs.add(place);
  EXPECT_EQ(places_of(runs, 10), places);
}

/// What walls and an outflow make of populations that all are different, in a step.
std::vector<double> after_step(const FluidSetup& setup, std::int64_t step) {
  Domain domain(setup, LatticeUnits(setup));
  const PopulationLayout layout(domain.box(), sizeof(double), origin_rule(domain, domain.box()));
  MovingWalls walls(domain, layout);
  OpenFaces faces(domain, layout);
  std::vector<double> populations(static_cast<std::size_t>(layout.values()));
  for (std::size_t i = 0; i < populations.size(); ++i) populations[i] = 1e-3 * std::sin(static_cast<double>(i));
  domain.set_step(step);
  faces.for_each_entering(
      populations.data(), Placement::home, [](std::int64_t) { return false; },
      [&](std::int64_t place, double value) { populations[static_cast<std::size_t>(place)] = value; });
  walls.apply(populations.data(), Placement::home);
  return populations;
}

// The walls beside an inflow have its velocity, so that all links look alike but for what varies.
TEST(MovingWalls, ThatVaryAreInEachStepAsWallsOfThatVelocity) {
  const Signal ramp{.kind = SignalKind::constant, .amplitude = 1.0, .ramp_steps = 8, .table = {}};
  const Signal wave{.kind = SignalKind::sinusoid, .amplitude = 1.0, .period_steps = 22, .lag_steps = 1.5, .table = {}};
  for (std::int64_t cells = 2; cells < 60; ++cells)  // equal places from both walls may differ by rounding
    for (const std::int64_t step : {0, 1, 3, 5, 6, 90}) {
      FluidSetup setup;
      setup.cell_size_m = setup.step_s = setup.density_kg_per_m3 = 1.0;
      setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
      setup.domain_cells = {5, cells, 6};
      for (const std::size_t face : {0, 2, 3, 4})
        setup.boundaries[face] = {.kind = BoundaryKind::velocity, .velocity_m_per_s = {0.02, 0.0, 0.0}};
      setup.boundaries[0].parabolic = cells > 2;
      setup.boundaries[2].velocity_m_per_s.z() = 0.01;  // in their edge both walls cancel
      setup.boundaries[4].velocity_m_per_s.y() = -0.01;
      setup.boundaries[1].kind = BoundaryKind::outflow;
      if (step > 1) setup.boundaries[5].kind = BoundaryKind::outflow;  // beside the inflow
      FluidSetup constant = setup;
      setup.boundaries[0].signal = setup.boundaries[3].signal = ramp;
      setup.boundaries[2].signal = wave;
      for (const std::size_t face : {0, 2, 3})
        constant.boundaries[face].velocity_m_per_s *= value_of(*setup.boundaries[face].signal, step, 0.5);
      EXPECT_EQ(after_step(setup, step), after_step(constant, 0)) << "step " << step << ", " << cells;
    }
}

}  // namespace
}  // namespace copepod::fluid
