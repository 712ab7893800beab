#include "model/body_block.hpp"

#include <gtest/gtest.h>

namespace copepod::body {
namespace {

SpringSpecification between(int A, int B) {
  SpringSpecification spring;
  spring.body_A = A;
  spring.body_B = B;
  return spring;
}

BodySetup joined(std::size_t bodies, const std::vector<SpringSpecification>& springs) {
  BodySetup setup;
  setup.bodies.resize(bodies);
  setup.springs = springs;
  return setup;
}

TEST(BodyBlock, CutsOnlyWhereNoSpringIsCut) {
  // Three swimmers, 0-1-2, 3-4-5, 6-7-8; blocks of about two bodies.
  const auto blocks = independent_blocks(
      joined(9, {between(0, 1), between(1, 2), between(4, 3), between(5, 4), between(6, 7), between(8, 7)}), 2);
  ASSERT_EQ(blocks.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(blocks[i].first, 3 * i);
    EXPECT_EQ(blocks[i].bodies, 3);
    EXPECT_EQ(blocks[i].springs, (std::vector<int>{2 * i, 2 * i + 1}));
  }
}

TEST(BodyBlock, KeepsTogetherWhatALongSpringSpans) {
  const auto blocks = independent_blocks(joined(6, {between(4, 1)}), 1);
  ASSERT_EQ(blocks.size(), 3U);
  EXPECT_EQ(blocks[1].first, 1);
  EXPECT_EQ(blocks[1].bodies, 4);
  EXPECT_EQ(blocks[1].springs, std::vector<int>{0});
  EXPECT_EQ(blocks[2].first, 5);
}

TEST(BodyBlock, KeepsTogetherWhatBendsAndPairForcesJoin) {
  BodySetup setup = joined(7, {});
  setup.bends = {{2, 0, 1, 1.0}};
  setup.actuators.resize(2);
  setup.actuators[0].body_A = 5;
  setup.actuators[0].body_B = 4;
  setup.actuators[1].kind = ActuatorKind::world_force;
  setup.actuators[1].body_A = 3;
  const auto blocks = independent_blocks(setup, 1);
  ASSERT_EQ(blocks.size(), 4U);
  EXPECT_EQ(blocks[0].bodies, 3);
  EXPECT_EQ(blocks[0].bends, std::vector<int>{0});
  EXPECT_EQ(blocks[1].bodies, 1);
  EXPECT_EQ(blocks[1].actuators, std::vector<int>{1});
  EXPECT_EQ(blocks[2].bodies, 2);
  EXPECT_EQ(blocks[2].actuators, std::vector<int>{0});
}

TEST(BodyBlock, HasOneLineForSpringAndPairForceBetweenTheSameCentres) {
  BodySetup setup = joined(6, {between(4, 5), between(3, 4), between(4, 5), between(4, 3)});
  setup.springs[2].anchor_B_m = {0, 0, 1};
  setup.actuators.resize(2);
  for (ActuatorSpecification& actuator : setup.actuators) actuator.body_A = 3;
  setup.actuators[0].kind = ActuatorKind::world_force;
  setup.actuators[1].body_B = 4;
  const auto block = independent_blocks(setup, 1).at(3);
  EXPECT_EQ(block.lines, (std::vector<std::array<int, 2>>{{0, 1}, {1, 0}, {1, 2}}));
  EXPECT_EQ(block.spring_lines, (std::vector<int>{2, 0, -1, 1}));
  EXPECT_EQ(block.actuator_lines, (std::vector<int>{-1, 0}));
}

TEST(BodyBlock, CoversBodiesWithoutSprings) {
  const auto blocks = independent_blocks(joined(10, {}), 4);
  ASSERT_EQ(blocks.size(), 3U);
  EXPECT_EQ(blocks[2].first, 8);
  EXPECT_EQ(blocks[2].bodies, 2);
}

TEST(BodyBlock, IsNotNeededWithoutBodies) { EXPECT_TRUE(independent_blocks(joined(0, {}), 4).empty()); }

}  // namespace
}  // namespace copepod::body
