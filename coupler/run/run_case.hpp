#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "checkpoint/checkpoint_store.hpp"
#include "config/load_case.hpp"
#include "contract/timeline.hpp"
#include "observers/events.hpp"
#include "run/checkpointer.hpp"
#include "run/components.hpp"
#include "run/summary.hpp"
#include "scheme/lubrication.hpp"
#include "scheme/serial_explicit.hpp"
#include "storage/run_directory.hpp"

namespace copepod::coupler {

/// Whether a run begins at step 0, at the newest checkpoint of its directory, or at that of another run.
enum class Beginning { fresh, resumed, branched };

/// Runs one case from connecting its components to the summary, and leaves a complete run directory.
class CaseRun {
 public:
  /// References must outlive this object.
  CaseRun(const LoadedCase& loaded, const RunDirectory& directory, Components& components, Events& events,
          RunSignals& signals)
      : loaded_(loaded), directory_(directory), components_(components), events_(events), signals_(signals) {}

  /// @param branch    where a run starts that is Beginning::branched
  /// @param on_ready  called with the first step, once both components are connected and the checkpoint was found
  /// @throws what a component, the disk or a signal makes fail; the caller reports it
  void run(Beginning beginning, const std::optional<Branch>& branch,
           const std::function<void(const Capabilities& fluid, const Capabilities& body, std::int64_t step)>& on_ready);

  /// Step that was being computed; −1 before the first. Meaningful after a failure too.
  [[nodiscard]] std::int64_t step() const { return step_; }

  /// What was reported to the user on the way: features that a component neglects, checkpoints left out, …
  [[nodiscard]] const std::vector<std::string>& notices() const { return notices_; }

 private:
  [[nodiscard]] FoundCheckpoint find_checkpoint(const CheckpointStore& store, std::optional<std::int64_t> step);
  void require_own_samples(const Branch& branch, std::int64_t step) const;
  void require_same_components(const CouplerState& state) const;
  void notice_missing_samples(const CouplerState& state);
  void notice(const std::string& text);
  void check_features(const Capabilities& capabilities, const std::set<std::string>& required);
  /// @param lowers  the body component lacks the setup's actuators and is driven by world forces
  void make_solvers(BodySetup body, bool lowers, const std::optional<FoundCheckpoint>& checkpoint);
  void compute(Beginning beginning, const CheckpointStore& store, const std::optional<FoundCheckpoint>& checkpoint);

  const LoadedCase& loaded_;
  const RunDirectory& directory_;
  Components& components_;
  Events& events_;
  RunSignals& signals_;
  Timeline timeline_;
  std::unique_ptr<FluidSolver> fluid_;
  std::unique_ptr<BodySolver> body_;
  VirtualMass virtual_mass_;
  Lubrication lubrication_;
  std::int64_t step_ = -1;
  std::vector<std::string> notices_;
};

}  // namespace copepod::coupler
