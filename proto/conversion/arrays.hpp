#pragma once

#include <algorithm>
#include <cmath>
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

inline void require_finite(const double* values, Eigen::Index count, const char* name) {
  const bool finite = std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
  if (!finite) throw MalformedMessage(std::string(name) + " holds a number that is not finite");
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
