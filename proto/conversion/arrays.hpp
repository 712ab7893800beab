#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <Eigen/Core>
#include <google/protobuf/repeated_field.h>

#include "conversion/finite.hpp"
#include "conversion/limits.hpp"

namespace copepod::conversion {

using Doubles = google::protobuf::RepeatedField<double>;

inline void require_length(std::size_t found, Eigen::Index length, const char* name) {
  if (found != static_cast<std::size_t>(length))
    throw MalformedMessage(std::string(name) + " holds " + std::to_string(found) + " numbers, not " +
                           std::to_string(length));
}

inline void require_finite(const double* values, Eigen::Index count, const char* name) {
  if (!all_finite(values, count)) throw NotFinite(std::string(name) + " holds a number that is not finite");
}

/// Copies an array of shape (rows, columns), one column per body, from the wire, where
/// numbers are not aligned.
template <class Matrix>
void read_array(std::span<const std::byte> bytes, Eigen::Index columns, const char* name, Matrix& matrix) {
  require_length(bytes.size() / sizeof(double), Matrix::RowsAtCompileTime * columns, name);
  matrix.resize(Matrix::RowsAtCompileTime, columns);
  if (copy_finite(bytes.data(), matrix.size(), matrix.data())) return;
  Eigen::Index column = 0;
  while (all_finite(matrix.col(column).data(), Matrix::RowsAtCompileTime)) ++column;
  for (const double value : matrix.col(column))
    if (!all_finite(&value, 1))
      throw NotFinite(std::string(name) + " of body " + std::to_string(column) + " is " + std::to_string(value));
}

inline void require_at_most(std::size_t size, std::size_t limit, const char* name) {
  if (size > limit)
    throw MalformedMessage(std::string(name) + " has " + std::to_string(size) + " entries or bytes, at most " +
                           std::to_string(limit) + " are allowed");
}

}  // namespace copepod::conversion
