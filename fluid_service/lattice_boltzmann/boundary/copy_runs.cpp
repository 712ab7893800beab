#include "lattice_boltzmann/boundary/copy_runs.hpp"

namespace copepod::fluid {

void CopyRuns::add(std::int64_t target, std::int64_t source, double addition) {
  ++values_;
  if (!runs_.empty() && runs_.back().addition == addition) {
    CopyRun& run = runs_.back();
    const std::int64_t target_step = target - run.target;
    const std::int64_t source_step = source - run.source;
    if (run.count == 1 && target_step == source_step && target_step != 0) {
      run.stride = target_step;
      run.count = 2;
      return;
    }
    if (run.count > 1 && target_step == run.count * run.stride && source_step == target_step) {
      ++run.count;
      return;
    }
  }
  runs_.push_back({.target = target, .source = source, .addition = addition});
}

}  // namespace copepod::fluid
