#pragma once

#include <array>
#include <cstddef>

namespace copepod::body {

// The loops over the bodies or lines of a block that take most of a step. Each is built for processors with and without
// AVX2, which give the same bits; the system's loader chooses. Arrays must not overlap unless they are the same.

/// Vectors or quaternions of one body after the other are copied to the arrays of their components.
void split(std::size_t size, const double* bodies, double* x, double* y, double* z);
void split(std::size_t size, const double* bodies, double* w, double* x, double* y, double* z);

/// The reverse.
void join(std::size_t size, const std::array<const double*, 3>& from, double* bodies);
void join(std::size_t size, const std::array<const double*, 4>& from, double* bodies);

/// to = a · b, number by number
void multiply(std::size_t size, const double* a, const double* b, double* to);

/// Whether none of the first `size` numbers of each row is inf or NaN.
/// @param stride  from one row to the next
bool all_finite(std::size_t rows, std::size_t stride, std::size_t size, const double* numbers);

/// sum += weight · rate,   to = start + factor · rate
void accumulate_and_extrapolate(std::size_t size, double weight, double factor, const double* start, const double* rate,
                                double* sum, double* to);

/// to += factor · (a + b)
void add_scaled_sum(std::size_t size, double factor, const double* a, const double* b, double* to);

/// dq/dt of (B10)
void orientation_rates(std::size_t size, const std::array<const double*, 3>& w, const std::array<const double*, 4>& q,
                       double* rate_w, double* rate_x, double* rate_y, double* rate_z);

/// Brings quaternions back to unit length, from which a step leaves them by its error.
void normalise_orientations(std::size_t size, const std::array<double*, 4>& q);

/// Lengths of vectors; the vectors become unit vectors.
void normalise_vectors(std::size_t size, const std::array<double*, 3>& vectors, double* length);

}  // namespace copepod::body
