#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "analysis/balance.hpp"
#include "analysis/cycle_observer.hpp"
#include "contract/exchange.hpp"
#include "driving/driving_protocol.hpp"
#include "storage/table_file.hpp"

namespace copepod::coupler {

/// Which steps enter the mean field: `start` and every so many after it.
struct MeanSampling {
  std::int64_t start = 0;
  std::int64_t every_steps = 0;

  bool operator==(const MeanSampling&) const = default;
};

/// The coupler's own part of what continues a run bit for bit; the solvers save the rest.
struct CouplerState {
  std::int64_t step = 0;            ///< that comes next
  std::int64_t first_step = 0;      ///< of the run; not 0 for one that starts from another run's checkpoint
  Loads previous_loads;             ///< of the load averaging; no bodies: none yet
  Kinematics previous_kinematics;   ///< of the virtual masses; no bodies: none yet, or none needed
  std::vector<CycleSums> swimmers;  ///< of the analysis, in the order of the case
  BalanceSums balance;              ///< since the run started
  TableEnds tables;                 ///< where the tables of the run directory ended
  MeanSampling mean;                ///< the fluid keeps its sums of the mean field for these steps only
  Loads loads;                      ///< hydrodynamic, of the step before
  std::vector<DrivingProtocol::Course> steered;  ///< by actuator and prescribed body
  std::vector<DrivingProtocol::Way> ways;        ///< of prescribed bodies
  std::string fluid_component;  ///< name of the component whose state lies beside this one; empty: unknown
  std::string body_component;
};

/// An integer of a checkpoint. A number of another kind is none: its value need not fit, and converting it
/// anyway is undefined behaviour.
/// @throws StorageError
template <class Integer>
Integer whole_number(const nlohmann::ordered_json& json);

nlohmann::ordered_json to_json(const CouplerState& state);

/// @throws StorageError if something is missing or of the wrong kind
CouplerState coupler_state_from_json(const nlohmann::ordered_json& json);

}  // namespace copepod::coupler
