#pragma once

#include <cstdint>
#include <vector>

namespace copepod::fluid {

/// Places in an array, kept as runs of equal stride.
class Runs {
 public:
  struct Run {
    std::int64_t first = 0;
    std::int64_t stride = 1;
    std::int64_t count = 1;
  };

  void add(std::int64_t place) {
    ++values_;
    if (!runs_.empty()) {
      Run& run = runs_.back();
      const std::int64_t step = place - run.first;
      if (run.count == 1 && step != 0) run.stride = step;
      if (step == run.count * run.stride) {
        ++run.count;
        return;
      }
    }
    runs_.push_back({.first = place});
  }

  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  [[nodiscard]] std::int64_t values() const { return values_; }

  /// visit(array[place]) for every place, in the order in which they were added.
  template <class T, class Visit>
  void for_each(T* array, Visit visit) const {
    for (const Run& run : runs_) {
      T* const first = array + run.first;
      if (run.stride == 1)
        for (std::int64_t i = 0; i < run.count; ++i) visit(first[i]);
      else
        for (std::int64_t i = 0; i < run.count; ++i) visit(first[i * run.stride]);
    }
  }

 private:
  std::vector<Run> runs_;
  std::int64_t values_ = 0;
};

}  // namespace copepod::fluid
