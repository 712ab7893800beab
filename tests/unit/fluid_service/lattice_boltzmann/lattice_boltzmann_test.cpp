#include "lattice_boltzmann/lattice_boltzmann.hpp"

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::fluid {
namespace {

constexpr std::int64_t mebibyte = 1 << 20;

FluidSetup channel() {
  FluidSetup setup;
  setup.cell_size_m = setup.step_s = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  setup.domain_cells = {100, 100, 200};
  return setup;
}

TEST(EstimateLatticeBoltzmann, CountsPopulationsGhostsAndPadding) {
  const std::int64_t bytes = estimate_lattice_boltzmann_bytes(channel(), 1);
  const std::int64_t populations = std::int64_t{19} * 8 * 100 * 100 * 200;
  EXPECT_GT(bytes, populations + 4 * 100 * 100 * 200);
  EXPECT_LT(static_cast<double>(bytes), 1.2 * static_cast<double>(populations));
}

TEST(EstimateLatticeBoltzmann, FallsWithRanksPrecisionAndSymmetry) {
  const auto whole = static_cast<double>(estimate_lattice_boltzmann_bytes(channel(), 1));
  EXPECT_NEAR(static_cast<double>(estimate_lattice_boltzmann_bytes(channel(), 4)) / whole, 0.26, 0.02);
  FluidSetup changed = channel();
  changed.precision = Precision::single_precision;
  EXPECT_NEAR(static_cast<double>(estimate_lattice_boltzmann_bytes(changed, 1)) / whole, 0.52, 0.02);
  changed = channel();
  changed.symmetry_planes = {true, true, false};
  EXPECT_NEAR(static_cast<double>(estimate_lattice_boltzmann_bytes(changed, 1)) / whole, 0.26, 0.02);
}

TEST(EstimateLatticeBoltzmann, CountsCopiesOfFieldsThatAreWritten) {
  FluidSetup setup = channel();
  const std::int64_t without = estimate_lattice_boltzmann_bytes(setup, 1);
  setup.fields.every_steps = 10;
  const std::int64_t snapshots = estimate_lattice_boltzmann_bytes(setup, 1);
  EXPECT_EQ(snapshots - without, (36 + 24) * std::int64_t{2'000'000} + 4 * mebibyte);
  setup.fields.quantities = {FieldQuantity::velocity, FieldQuantity::vorticity};
  EXPECT_EQ(estimate_lattice_boltzmann_bytes(setup, 1) - snapshots, 24 * 2'000'000);
  setup.fields.quantities.clear();
  setup.fields.mean_stop = 100;
  EXPECT_EQ(estimate_lattice_boltzmann_bytes(setup, 1) - snapshots, 36 * 2'000'000);
}

TEST(EstimateLatticeBoltzmann, RefusesRanksThatCannotCutTheDomain) {
  try {
    estimate_lattice_boltzmann_bytes(channel(), 211);
    FAIL() << "211 is prime and longer than every axis";
  } catch (const CaseError& error) {
    EXPECT_NE(std::string(error.what()).find("ranks 211"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("Use 210 ranks"), std::string::npos);
  }
}

}  // namespace
}  // namespace copepod::fluid
