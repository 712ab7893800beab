#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include <Eigen/Core>
#include <google/protobuf/repeated_field.h>

#include "conversion/malformed_message.hpp"

namespace copepod::conversion {

using Doubles = google::protobuf::RepeatedField<double>;

/// Overwrites `field` with `count` doubles; one memcpy, no allocation once the field has grown.
inline void assign(Doubles& field, const double* values, Eigen::Index count) {
  const int size = static_cast<int>(count);
  field.Clear();
  field.Reserve(size);
  double* target = field.AddNAlreadyReserved(size);
  if (size > 0) std::memcpy(target, values, sizeof(double) * static_cast<std::size_t>(size));
}

template <class Derived>
void assign(Doubles& field, const Eigen::PlainObjectBase<Derived>& matrix) {
  assign(field, matrix.data(), matrix.size());
}

inline void require_length(const Doubles& field, Eigen::Index length, const char* name) {
  if (field.size() != length) {
    throw MalformedMessage(std::string(name) + " holds " + std::to_string(field.size()) + " numbers, not " +
                           std::to_string(length));
  }
}

/// Whether all numbers are finite. Adding one to an exponent of all ones, that of infinities and NaN, carries
/// into the sign bit; so the loop has no branch and compilers make vector instructions of it.
inline bool all_finite(const double* values, Eigen::Index count) {
  constexpr std::uint64_t exponent = 0x7FF0'0000'0000'0000, one = 0x0010'0000'0000'0000;
  std::uint64_t carried = 0;
  for (Eigen::Index i = 0; i < count; ++i)
    carried |= (std::bit_cast<std::uint64_t>(values[i]) & exponent) + one;
  return carried >> 63U == 0;
}

inline void require_finite(const double* values, Eigen::Index count, const char* name) {
  if (!all_finite(values, count))
    throw MalformedMessage(std::string(name) + " holds a number that is not finite");
}

/// Copies an array of shape (rows, columns); the sum of a memcpy and two checks.
template <class Matrix>
void read_array(const Doubles& field, Eigen::Index columns, const char* name, Matrix& matrix) {
  require_length(field, Matrix::RowsAtCompileTime * columns, name);
  require_finite(field.data(), field.size(), name);
  matrix.resize(Matrix::RowsAtCompileTime, columns);
  if (field.size() > 0)
    std::memcpy(matrix.data(), field.data(), sizeof(double) * static_cast<std::size_t>(field.size()));
}

/// Copies a vector of fixed length.
template <class Vector>
Vector read_vector(const Doubles& field, const char* name) {
  require_length(field, Vector::RowsAtCompileTime, name);
  require_finite(field.data(), field.size(), name);
  return Eigen::Map<const Vector>(field.data());
}

inline double read_finite(double value, const char* name) {
  require_finite(&value, 1, name);
  return value;
}

inline void require_at_most(std::size_t size, std::size_t limit, const char* name) {
  if (size > limit) {
    throw MalformedMessage(std::string(name) + " has " + std::to_string(size) +
                           " entries or bytes, at most " + std::to_string(limit) + " are allowed");
  }
}

}  // namespace copepod::conversion
