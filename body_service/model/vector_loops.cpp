#include "model/vector_loops.hpp"

#include <bit>
#include <cmath>
#include <cstdint>

#include "geometry/rotation.hpp"

#if defined(__x86_64__) && defined(__ELF__)
#define COPEPOD_WITH_AND_WITHOUT_AVX2 __attribute__((target_clones("avx2", "default")))
#else
#define COPEPOD_WITH_AND_WITHOUT_AVX2
#endif

namespace copepod::body {

COPEPOD_WITH_AND_WITHOUT_AVX2
void split(std::size_t size, const double* bodies, double* __restrict x, double* __restrict y, double* __restrict z) {
  for (std::size_t i = 0; i < size; ++i) {
    x[i] = bodies[3 * i];
    y[i] = bodies[3 * i + 1];
    z[i] = bodies[3 * i + 2];
  }
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void split(std::size_t size, const double* bodies, double* __restrict w, double* __restrict x, double* __restrict y,
           double* __restrict z) {
  for (std::size_t i = 0; i < size; ++i) {
    w[i] = bodies[4 * i];
    x[i] = bodies[4 * i + 1];
    y[i] = bodies[4 * i + 2];
    z[i] = bodies[4 * i + 3];
  }
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void join(std::size_t size, const std::array<const double*, 3>& from, double* __restrict bodies) {
  const auto [x, y, z] = from;
  for (std::size_t i = 0; i < size; ++i) {
    bodies[3 * i] = x[i];
    bodies[3 * i + 1] = y[i];
    bodies[3 * i + 2] = z[i];
  }
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void join(std::size_t size, const std::array<const double*, 4>& from, double* __restrict bodies) {
  const auto [w, x, y, z] = from;
  for (std::size_t i = 0; i < size; ++i) {
    bodies[4 * i] = w[i];
    bodies[4 * i + 1] = x[i];
    bodies[4 * i + 2] = y[i];
    bodies[4 * i + 3] = z[i];
  }
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void multiply(std::size_t size, const double* a, const double* b, double* to) {
  for (std::size_t i = 0; i < size; ++i) to[i] = a[i] * b[i];
}

COPEPOD_WITH_AND_WITHOUT_AVX2
bool all_finite(std::size_t rows, std::size_t stride, std::size_t size, const double* numbers) {
  // One added to an exponent of ones runs over into the sign.
  constexpr std::uint64_t sign = 1ULL << 63;
  std::uint64_t any = 0;
  for (; rows > 0; --rows, numbers += stride)
    for (std::size_t i = 0; i < size; ++i) any |= (std::bit_cast<std::uint64_t>(numbers[i]) & ~sign) + (1ULL << 52);
  return (any & sign) == 0;
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void accumulate_and_extrapolate(std::size_t size, double weight, double factor, const double* start, const double* rate,
                                double* __restrict sum, double* __restrict to) {
  for (std::size_t i = 0; i < size; ++i) {
    sum[i] += weight * rate[i];
    to[i] = start[i] + factor * rate[i];
  }
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void add_scaled_sum(std::size_t size, double factor, const double* a, const double* b, double* __restrict to) {
  for (std::size_t i = 0; i < size; ++i) to[i] += factor * (a[i] + b[i]);
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void orientation_rates(std::size_t size, const std::array<const double*, 3>& w, const std::array<const double*, 4>& q,
                       double* __restrict rate_w, double* __restrict rate_x, double* __restrict rate_y,
                       double* __restrict rate_z) {
  for (std::size_t i = 0; i < size; ++i) {
    const auto rate =
        orientation_rate(std::array{w[0][i], w[1][i], w[2][i]}, std::array{q[0][i], q[1][i], q[2][i], q[3][i]});
    rate_w[i] = rate[0];
    rate_x[i] = rate[1];
    rate_y[i] = rate[2];
    rate_z[i] = rate[3];
  }
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void normalise_orientations(std::size_t size, const std::array<double*, 4>& q) {
  // Within rounding of unit length nothing is gained, and a body that does not turn must keep its bits.
  constexpr double rounding = 2e-15;
  double* const w = q[0];
  double* const x = q[1];
  double* const y = q[2];
  double* const z = q[3];
  for (std::size_t i = 0; i < size; ++i) {
    const double squared_norm = (w[i] * w[i] + y[i] * y[i]) + (x[i] * x[i] + z[i] * z[i]);
    const double factor = std::abs(squared_norm - 1.0) > rounding ? 1.0 / std::sqrt(squared_norm) : 1.0;
    w[i] *= factor;
    x[i] *= factor;
    y[i] *= factor;
    z[i] *= factor;
  }
}

COPEPOD_WITH_AND_WITHOUT_AVX2
void normalise_vectors(std::size_t size, const std::array<double*, 3>& vectors, double* __restrict length) {
  double* const x = vectors[0];
  double* const y = vectors[1];
  double* const z = vectors[2];
  for (std::size_t i = 0; i < size; ++i) {
    length[i] = std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
    x[i] /= length[i];
    y[i] /= length[i];
    z[i] /= length[i];
  }
}

}  // namespace copepod::body
