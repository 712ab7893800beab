#pragma once

#include <array>

#include <Eigen/Core>

#include "model/motion_state.hpp"

namespace copepod::body {

/// Some pairs of bodies that push or pull along the line between their centres: gathered, so that loops over them use
/// vectors of the processor, and scattered one by one, in the order in which they came.
struct PairBatch {  // NOLINT(cppcoreguidelines-pro-type-member-init): its arrays are filled up to `size`
  static constexpr int most = 64;
  using Numbers = std::array<double, most>;

  [[nodiscard]] bool full() const { return size == most; }

  /// @param A, B  columns of `position_m`
  void add(Eigen::Index A, Eigen::Index B, const BlockVectors& position_m) {
    ends_A[size] = A;
    ends_B[size] = B;
    for (int i = 0; i < 3; ++i) d_AB_m[i][size] = position_m(i, B) - position_m(i, A);
    ++size;
  }

  [[nodiscard]] bool coincide(int pair) const {
    return d_AB_m[0][pair] == 0.0 && d_AB_m[1][pair] == 0.0 && d_AB_m[2][pair] == 0.0;
  }

  /// Adds force number `pair` to its end A, and its negative to end B.
  void add_force(int pair, BlockVectors& force_N) const {
    for (int i = 0; i < 3; ++i) {
      force_N(i, ends_A[pair]) += force_A_N[i][pair];
      force_N(i, ends_B[pair]) -= force_A_N[i][pair];
    }
  }

  int size = 0;
  std::array<Eigen::Index, most> ends_A;
  std::array<Eigen::Index, most> ends_B;
  std::array<Numbers, 3> d_AB_m;  ///< from A to B
  std::array<Numbers, 3> force_A_N;
};

}  // namespace copepod::body
