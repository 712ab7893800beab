#include "scheme/load_averaging.hpp"

namespace copepod::coupler {

void LoadAverage::apply(const Loads& raw, Loads& applied) {
  if (kind_ == LoadAveraging::none) {
    applied = raw;
    return;
  }
  if (previous_.bodies() != raw.bodies()) previous_ = raw;  // the first step averages with itself
  applied.step = raw.step;
  applied.force_N = 0.5 * (raw.force_N + previous_.force_N);
  applied.torque_N_m = 0.5 * (raw.torque_N_m + previous_.torque_N_m);
  previous_ = raw;
}

}  // namespace copepod::coupler
