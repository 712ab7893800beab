#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

// Flat binary between ranks of one executable: same machine code on both sides, so bytes travel as they lie
// in memory. `Packer` and `Unpacker` take the same `archive(value)` calls, so one function describes a struct
// for both directions.

namespace copepod::fluid {

template <class T>
concept Flat = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

/// Appends values to a byte buffer.
class Packer {
 public:
  explicit Packer(std::vector<std::byte>& bytes) : bytes_(bytes) {}

  template <Flat T>
  void operator()(const T& value) {
    append(&value, sizeof(T));
  }
  void operator()(const std::string& text) {
    (*this)(text.size());
    append(text.data(), text.size());
  }
  template <int rows>
  void operator()(const Eigen::Matrix<double, rows, Eigen::Dynamic>& matrix) {
    (*this)(matrix.cols());
    append(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }

 private:
  void append(const void* data, std::size_t size) {
    if (size == 0) return;
    const std::size_t end = bytes_.size();
    bytes_.resize(end + size);
    std::memcpy(bytes_.data() + end, data, size);
  }

  std::vector<std::byte>& bytes_;
};

/// Reads values in the order in which a Packer wrote them.
class Unpacker {
 public:
  explicit Unpacker(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <Flat T>
  void operator()(T& value) {
    take(&value, sizeof(T));
  }
  void operator()(std::string& text) {
    std::size_t size = 0;
    (*this)(size);
    if (size > bytes_.size()) throw too_short();
    text.resize(size);
    take(text.data(), size);
  }
  template <int rows>
  void operator()(Eigen::Matrix<double, rows, Eigen::Dynamic>& matrix) {
    Eigen::Index size = 0;
    (*this)(size);
    if (static_cast<std::size_t>(size) * rows * sizeof(double) > bytes_.size()) throw too_short();
    matrix.resize(rows, size);
    take(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }

 private:
  static std::logic_error too_short() { return std::logic_error("message between ranks is shorter than its contents"); }
  void take(void* data, std::size_t size) {
    if (size > bytes_.size()) throw too_short();
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }

  std::span<const std::byte> bytes_;
};

}  // namespace copepod::fluid
