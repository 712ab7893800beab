#include "lattice_boltzmann/output/mean_field.hpp"

#include <stdexcept>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

FieldBlock two_cells(double density, double velocity_z, std::int32_t body) {
  return {
      {{0, 0, 0}, {1, 1, 2}}, {density, density + 1}, {0, 0, velocity_z, 0, 0, 2 * velocity_z}, {0, body}};
}

TEST(MeanField, AveragesDensityAndVelocityAndKeepsTheLastBodies) {
  MeanField field;
  field.add(two_cells(1000, 1.0, 0));
  field.add(two_cells(1004, 4.0, 2));
  EXPECT_EQ(field.samples(), 2);
  const FieldBlock mean = field.mean();
  EXPECT_EQ(mean.density_kg_per_m3, (std::vector<double>{1002, 1003}));
  EXPECT_EQ(mean.velocity_m_per_s, (std::vector<double>{0, 0, 2.5, 0, 0, 5}));
  EXPECT_EQ(mean.body, (std::vector<std::int32_t>{0, 2}));
}

TEST(MeanField, GoesOnFromRestoredSumsWithoutADifference) {
  MeanField whole;
  MeanField first_half;
  for (int sample = 0; sample < 3; ++sample) {
    whole.add(two_cells(1000.1 * sample, 0.3 * sample, 0));
    first_half.add(two_cells(1000.1 * sample, 0.3 * sample, 0));
  }
  MeanField resumed;
  resumed.restore(first_half.samples(), first_half.sums());
  whole.add(two_cells(7, 0.7, 1));
  resumed.add(two_cells(7, 0.7, 1));
  EXPECT_EQ(resumed.mean().density_kg_per_m3, whole.mean().density_kg_per_m3);
  EXPECT_EQ(resumed.mean().velocity_m_per_s, whole.mean().velocity_m_per_s);
}

TEST(MeanField, RefusesASampleOfOtherCells) {
  MeanField field;
  field.add(two_cells(1000, 1.0, 0));
  FieldBlock shifted = two_cells(1000, 1.0, 0);
  shifted.box = {{1, 0, 0}, {2, 1, 2}};
  EXPECT_THROW(field.add(shifted), std::logic_error);
}

}  // namespace
}  // namespace copepod::fluid
