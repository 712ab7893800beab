#include "model/vector_loops.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "model/body_block.hpp"

namespace copepod::body {
namespace {

TEST(VectorLoops, SplitABlockIntoComponentsAndJoinItAgain) {
  const Eigen::Matrix3Xd vectors = Eigen::Matrix3Xd::Random(3, 20);
  const Eigen::Matrix4Xd quaternions = Eigen::Matrix4Xd::Random(4, 20);
  for (int bodies = 0; bodies < 14; ++bodies) {
    const BodyBlock block{.first = 3, .bodies = bodies};
    BlockVectors vectors_of_block = BlockVectors::Zero(3, 15);
    BlockState state;
    state.resize(15);
    split(vectors, block, vectors_of_block);
    split(quaternions, block, state.orientation_wxyz);
    EXPECT_EQ(vectors_of_block.leftCols(bodies), vectors.middleCols(3, bodies));
    EXPECT_EQ(state.orientation_wxyz.leftCols(bodies), quaternions.middleCols(3, bodies));
    EXPECT_TRUE(vectors_of_block.rightCols(15 - bodies).isZero(0.0));

    Eigen::Matrix3Xd joined_vectors = Eigen::Matrix3Xd::Zero(3, 20);
    Eigen::Matrix4Xd joined_quaternions = Eigen::Matrix4Xd::Zero(4, 20);
    join(vectors_of_block, block, joined_vectors);
    join(state.orientation_wxyz, block, joined_quaternions);
    EXPECT_EQ(joined_vectors.middleCols(3, bodies), vectors.middleCols(3, bodies));
    EXPECT_EQ(joined_quaternions.middleCols(3, bodies), quaternions.middleCols(3, bodies));
    EXPECT_TRUE(joined_vectors.leftCols(3).isZero(0.0) && joined_vectors.rightCols(17 - bodies).isZero(0.0));
  }
}

TEST(VectorLoops, SeeEveryNumberThatIsNotFinite) {
  using Limits = std::numeric_limits<double>;
  BlockVectors numbers(3, 11);
  for (const double finite : {Limits::max(), Limits::lowest(), Limits::denorm_min(), -0.0}) {
    numbers.setConstant(finite);
    EXPECT_TRUE(all_finite(3, 11, 11, numbers.data()));
    for (const double bad : {Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(), -Limits::quiet_NaN()}) {
      for (Eigen::Index i = 0; i < numbers.size(); ++i) {
        numbers.data()[i] = bad;
        EXPECT_FALSE(all_finite(3, 11, 11, numbers.data()));
        EXPECT_EQ(all_finite(3, 11, 7, numbers.data()), i % 11 >= 7);
        numbers.data()[i] = finite;
      }
    }
  }
}

}  // namespace
}  // namespace copepod::body
