#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "analysis/balance.hpp"
#include "analysis/cycle_observer.hpp"
#include "contract/exchange.hpp"
#include "contract/solver.hpp"
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

/// Writes `folder`/manifest.json: case, step, and size and checksum of every other file below `folder`.
/// @throws StorageError
void write_manifest(const std::filesystem::path& folder, const std::string& case_key, std::int64_t step);

/// Compares a folder with its manifest.
/// @return what is wrong with it, empty if nothing is
std::string find_damage(const std::filesystem::path& folder, const std::string& case_key);

/// The solvers of a run by the names of their files.
using SolversByFile = std::vector<std::pair<std::string, Solver*>>;
inline constexpr const char* fluid_file = "fluid.h5";
inline constexpr const char* body_file = "body.bin";
inline std::string controller_file(const std::string& name) { return "controller." + name + ".bin"; }

/// A checkpoint that can be resumed.
struct FoundCheckpoint {
  std::filesystem::path folder;
  CouplerState state;
  std::vector<std::string> skipped;  ///< newer ones that could not be used, and why
};

/// The checkpoints of a run: `checkpoints/step_000001000/` with fluid.h5, body.bin, a controller.NAME.bin for each,
/// coupler.json and manifest.json.
///
/// Writing takes two phases: everything goes to a folder with another name first; once it is complete and on
/// the disk the folder gets its name. So a checkpoint that has a name is complete, and one that was damaged
/// later is found out by the checksums in its manifest. The newest two are kept; those of later steps than
/// the newest could not be used when the run was resumed, and go.
class CheckpointStore {
 public:
  /// @param case_key  what makes two runs the same case; a checkpoint of another one is not used
  CheckpointStore(std::filesystem::path folder, std::string case_key)
      : folder_(std::move(folder)), case_key_(std::move(case_key)) {}

  /// First phase: lets all solvers save, and saves the coupler's state beside them. Legal between two steps.
  /// @throws StorageError, and what the solvers throw; older checkpoints stay as they are
  void prepare(const SolversByFile& solvers, const CouplerState& state);

  /// Second phase: reads everything back for its checksums, and makes it the newest checkpoint. Takes long
  /// for large ones, and needs no solver.
  /// @param step  that was prepared
  /// @throws StorageError; older checkpoints stay as they are
  void commit(std::int64_t step);

  /// The newest complete, undamaged checkpoint of this case, or that before `wanted`. Large ones take long.
  /// @throws StorageError if there is none
  [[nodiscard]] FoundCheckpoint find(std::optional<std::int64_t> wanted = {}) const;
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

  /// Bytes of the newest checkpoint, 0 if there is none; what the next one will need, more or less.
  [[nodiscard]] std::uintmax_t newest_bytes() const;

 private:
  [[nodiscard]] std::map<std::int64_t, std::filesystem::path, std::greater<>> newest_first() const;  ///< by step
  void keep_two_up_to(std::int64_t newest) const;
  void or_remove_draft(const std::function<void()>& write) const;

  std::filesystem::path folder_;
  std::string case_key_;
};

/// Free bytes of the disk that holds `path`.
std::uintmax_t free_bytes(const std::filesystem::path& path);

}  // namespace copepod::coupler
