#include "lattice_boltzmann/output/fields.hpp"

#include <stdexcept>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

FieldBlock two_cells(double density, double velocity_z, std::int32_t body) {
  return {{{0, 0, 0}, {1, 1, 2}}, {density, density + 1}, {0, 0, velocity_z, 0, 0, 2 * velocity_z}, {0, body}};
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

const Box everything{{0, 0, 0}, {100, 100, 100}};

/// A block whose density is 100 x + 10 y + z and whose velocity is (1, 2, 3) everywhere.
FieldBlock numbered(const Box& box) {
  FieldBlock block;
  block.box = box;
  for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
      for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) {
        block.density_kg_per_m3.push_back(static_cast<double>(100 * x + 10 * y + z));
        block.velocity_m_per_s.insert(block.velocity_m_per_s.end(), {1, 2, 3});
        block.body.push_back(static_cast<std::int32_t>(x));
      }
  return block;
}

TEST(MirrorImages, TransposesToXFastestWithoutSymmetry) {
  const MirrorImages images({4, 4, 4}, {false, false, false});
  ASSERT_EQ(images.images().size(), 1U);
  const FieldBlock block = numbered({{1, 0, 2}, {3, 2, 4}});
  const std::array<bool, 3> itself{};
  const auto density = images.image(block.box, block.density_kg_per_m3, Reflection::scalar, itself, everything);
  EXPECT_EQ(density.box, (Box{{1, 0, 2}, {3, 2, 4}}));
  EXPECT_EQ(density.values, (std::vector<double>{102, 202, 112, 212, 103, 203, 113, 213}));
  EXPECT_EQ(images.image(block.box, block.body, Reflection::scalar, itself, everything).values,
            (std::vector<std::int32_t>{1, 2, 1, 2, 1, 2, 1, 2}));
}

TEST(MirrorImages, ReversesCellsAndNormalVelocityBehindAPlane) {
  const MirrorImages images({8, 4, 4}, {true, false, false});
  const FieldBlock block = numbered({{1, 0, 0}, {3, 1, 1}});
  const auto image = [&](const std::vector<double>& values, Reflection reflection) {
    return images.image(block.box, values, reflection, {true, false, false}, everything);
  };
  EXPECT_EQ(image(block.density_kg_per_m3, Reflection::scalar).box, (Box{{5, 0, 0}, {7, 1, 1}}));
  EXPECT_EQ(image(block.density_kg_per_m3, Reflection::scalar).values, (std::vector<double>{200, 100}));
  EXPECT_EQ(image(block.velocity_m_per_s, Reflection::vector).values, (std::vector<double>{-1, 2, 3, -1, 2, 3}));
}

TEST(MirrorImages, KeepTheNormalVorticityAndReverseTheOthersAtEachPlane) {
  const MirrorImages images({8, 4, 4}, {true, true, false});
  const FieldBlock block = numbered({{0, 0, 0}, {1, 1, 1}});
  const auto vorticity = [&](const std::array<bool, 3>& mirrored) {
    return images.image(block.box, block.velocity_m_per_s, Reflection::axial_vector, mirrored, everything).values;
  };
  EXPECT_EQ(vorticity({false, false, false}), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(vorticity({true, false, false}), (std::vector<double>{1, -2, -3}));
  EXPECT_EQ(vorticity({true, true, false}), (std::vector<double>{-1, -2, 3}));
}

TEST(MirrorImages, LeaveOutCellsBeyondTheRegion) {
  const MirrorImages images({8, 4, 4}, {true, false, false});
  const FieldBlock block = numbered({{0, 0, 0}, {4, 2, 1}});
  const Box region{{3, 1, 0}, {6, 4, 1}};
  const auto density = [&](const std::array<bool, 3>& mirrored) {
    return images.image(block.box, block.density_kg_per_m3, Reflection::scalar, mirrored, region);
  };
  EXPECT_EQ(density({}).box, (Box{{3, 1, 0}, {4, 2, 1}}));
  EXPECT_EQ(density({}).values, (std::vector<double>{310}));
  EXPECT_EQ(density({true, false, false}).values, (std::vector<double>{310, 210}));
  EXPECT_TRUE(images.image({{0, 0, 2}, {4, 2, 4}}, block.body, Reflection::scalar, {}, region).values.empty());
}

TEST(MirrorImages, CoverTheWholeDomainExactlyOnce) {
  const MirrorImages images({4, 6, 3}, {true, true, false});
  std::map<Cell, int> covered;
  for (const Box& block : {Box{{0, 0, 0}, {2, 1, 3}}, Box{{0, 1, 0}, {2, 3, 3}}})
    for (const auto& mirrored : images.images()) {
      const Box box = images.image(block, numbered(block).body, Reflection::scalar, mirrored, everything).box;
      for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
        for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
          for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) ++covered[{x, y, z}];
    }
  EXPECT_EQ(covered.size(), 4U * 6U * 3U);
  for (const auto& [cell, times] : covered) EXPECT_EQ(times, 1);
}

TEST(MirrorImages, AreEightWithThreePlanes) {
  EXPECT_EQ(MirrorImages({2, 2, 2}, {true, true, true}).images().size(), 8U);
}

}  // namespace
}  // namespace copepod::fluid
