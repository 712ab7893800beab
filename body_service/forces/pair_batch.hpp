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

  /// @param A, B      columns
  /// @param position_m  components
  void add(int A, int B, const std::array<const double*, 3>& position_m) {
    ends_A[size] = A;
    ends_B[size] = B;
    for (int i = 0; i < 3; ++i) d_AB_m[i][size] = position_m[i][B] - position_m[i][A];
    ++size;
  }

  /// Vector number `pair` of three arrays.
  static std::array<double, 3> at(const std::array<Numbers, 3>& vectors, int pair) {
    return {vectors[0][pair], vectors[1][pair], vectors[2][pair]};
  }

  /// Adds the forces to the ends A, and their negatives to the ends B.
  /// @param coincide  is called with the number of a pair whose ends coincide: its force is not a number
  template <class Coincide>
  void add_forces(BlockVectors& force_N, const Coincide& coincide) const {
    const auto force = components(force_N);
    for (int pair = 0; pair < size; ++pair) {
      const auto f_N = at(force_A_N, pair);
      if (f_N[0] != f_N[0] && at(d_AB_m, pair) == std::array{0.0, 0.0, 0.0}) coincide(pair);
      for (int i = 0; i < 3; ++i) {
        force[i][ends_A[pair]] += f_N[i];
        force[i][ends_B[pair]] -= f_N[i];
      }
    }
  }

  int size = 0;
  std::array<int, most> ends_A;
  std::array<int, most> ends_B;
  std::array<Numbers, 3> d_AB_m;  ///< from A to B
  std::array<Numbers, 3> force_A_N;
};

}  // namespace copepod::body
