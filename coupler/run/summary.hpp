#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "config/sections/case.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_solver.hpp"

namespace copepod::coupler {

/// Where the time of a run went; seconds of wall time.
struct RunTiming {
  std::int64_t first_step = 0;  ///< not 0 where a checkpoint was resumed
  double loop_s = 0.0;          ///< from the first exchange until the fluid had nothing left to do
  double fluid_wait_s = 0.0;    ///< the coupler waited for the fluid
  double body_wait_s = 0.0;     ///< the coupler waited for the bodies
};

/// Digest of a whole run: of the fluid's state, the bodies' state and the final kinematics, in this order.
std::uint64_t run_digest(const SolverSummary& fluid, const SolverSummary& body, const Kinematics& kinematics);

/// Content of summary.json (docs: "The run directory").
/// @param swimmers  its keys about swimmers, and the balance of the bodies
nlohmann::ordered_json make_summary(const Case& the_case, std::int64_t steps_done, const SolverSummary& fluid,
                                    const SolverSummary& body, const Kinematics& kinematics, const RunTiming& timing,
                                    const nlohmann::ordered_json& swimmers);

}  // namespace copepod::coupler
