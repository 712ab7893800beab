#include "lattice_boltzmann/bodies/load_sums.hpp"

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace fixed_point {
namespace {

TEST(FixedPoint, RoundsToTheUnitAndKeepsTheSign) {
  EXPECT_EQ(to_double(sum_from_double(1.0 + 0.4 * unit)), 1.0);
  EXPECT_EQ(to_double(sum_from_double(-0.6 * unit)), -unit);
  for (const double value : {4095.5, 4096.0, 8192.0, 1e6 / 3.0, 1e16}) {
    EXPECT_EQ(to_double(sum_from_double(value)), value);
    EXPECT_EQ(to_double(sum_from_double(-value)), -value);
  }
}

TEST(FixedPoint, SumsBeyondTheRangeOf64Bits) {
  Sum sum = 0;
  for (int link = 0; link < 1000; ++link) sum += sum_from_double(-8191.25);
  EXPECT_EQ(to_double(sum), -8191250.0);
}

TEST(FixedPoint, AddsUpHalvesOfRanksOfEitherSign) {
  for (const double value : {0.0, 3.0 * unit, -unit, 1e5 / 7.0, -1e5 / 7.0, -1e14}) {
    const Halves first = halves(sum_from_double(value));
    const Halves second = halves(sum_from_double(-12345.0));
    EXPECT_GE(first[0], 0);
    EXPECT_EQ(from_halves(first[0] + second[0], first[1] + second[1]),
              sum_from_double(value) + sum_from_double(-12345.0));
  }
}

}  // namespace
}  // namespace fixed_point
}  // namespace copepod::fluid
