#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace copepod::fluid {

/// `count` values, `stride` apart, from `source` to `target`; both are the same place for packing and
/// unpacking.
struct CopyRun {
  std::int64_t target = 0;
  std::int64_t source = 0;
  std::int64_t stride = 1;
  std::int64_t count = 1;
  double addition = 0.0;
};

/// Collects single copies into runs of equal stride.
class CopyRuns {
 public:
  void add(std::int64_t target, std::int64_t source, double addition = 0.0);
  /// One side only, for packing or unpacking.
  void add(std::int64_t location) { add(location, location); }
  [[nodiscard]] std::span<const CopyRun> runs() const { return runs_; }
  [[nodiscard]] std::int64_t values() const { return values_; }

  /// values[target] = values[source] + addition, for all.
  template <class T>
  void copy(T* values) const {
    for (const CopyRun& run : runs_) {
      T* target = values + run.target;
      const T* source = values + run.source;
      const T addition = static_cast<T>(run.addition);
      if (run.stride == 1) {
        for (std::int64_t i = 0; i < run.count; ++i) target[i] = source[i] + addition;
      } else {
        for (std::int64_t i = 0; i < run.count; ++i)
          target[i * run.stride] = source[i * run.stride] + addition;
      }
    }
  }
  /// Sources in order into a buffer.
  template <class T>
  void pack(const T* values, T* buffer) const {
    for (const CopyRun& run : runs_) {
      const T* source = values + run.source;
      if (run.stride == 1) {
        std::copy_n(source, run.count, buffer);
      } else {
        for (std::int64_t i = 0; i < run.count; ++i) buffer[i] = source[i * run.stride];
      }
      buffer += run.count;
    }
  }
  /// A buffer in order into the targets.
  template <class T>
  void unpack(T* values, const T* buffer) const {
    for (const CopyRun& run : runs_) {
      T* target = values + run.target;
      if (run.stride == 1) {
        std::copy_n(buffer, run.count, target);
      } else {
        for (std::int64_t i = 0; i < run.count; ++i) target[i * run.stride] = buffer[i];
      }
      buffer += run.count;
    }
  }

 private:
  std::vector<CopyRun> runs_;
  std::int64_t values_ = 0;
};

}  // namespace copepod::fluid
