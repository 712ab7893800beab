#include "ranks/rank_failure.hpp"

#include <new>
#include <string>

#include "system/host_name.hpp"

namespace copepod::fluid {

FailureReport failure_of_rank(const std::exception& error, int rank, std::int64_t step) {
  FailureReport report;
  report.component = "fluid";
  report.host = host_name();
  report.rank = rank;
  report.step = step;
  report.reason = error.what();
  if (const auto* known = dynamic_cast<const Error*>(&error)) {
    report.code = known->code();
    if (known->step() >= 0) report.step = known->step();
  } else if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    report.reason =
        "out of memory (the rank's block of cells does not fit). Use more machines or a smaller domain.";
  }
  return report;
}

}  // namespace copepod::fluid
