#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "analysis/balance.hpp"
#include "analysis/cycle_observer.hpp"
#include "checkpoint/checkpoint_store.hpp"
#include "config/load_case.hpp"
#include "contract/timeline.hpp"
#include "driving/driving_protocol.hpp"
#include "observers/bodies_writer.hpp"
#include "observers/events.hpp"
#include "observers/observer.hpp"
#include "observers/trajectory_writer.hpp"
#include "run/checkpointer.hpp"
#include "run/components.hpp"
#include "run/summary.hpp"
#include "scheme/serial_explicit.hpp"
#include "storage/run_directory.hpp"

namespace copepod::coupler {

/// The observers of a run: trajectory, surfaces of the bodies, analysis, progress.
class RunObservers final : public Observer {
 public:
  /// References must outlive this object.
  /// @param resumed  the checkpoint that the run continues from; null: it starts
  /// @param step     receives the step that is being computed
  /// @throws StorageError if files cannot be written, or are not what the checkpoint needs
  RunObservers(const LoadedCase& loaded, const RunDirectory& directory, Events& events, const CouplerState* resumed,
               std::int64_t& step);

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  [[nodiscard]] CycleObserver& cycles() { return cycles_; }
  [[nodiscard]] Balance& balance() { return balance_; }

  /// Brings all rows so far to the disk.
  /// @return where the tables end now
  TableEnds sync_files();

 private:
  const RunDirectory& directory_;
  std::int64_t& step_;
  std::filesystem::path trajectory_path_;
  std::unique_ptr<TrajectoryWriter> trajectory_;
  std::filesystem::path obstacles_path_;
  std::optional<ObstacleWriter> obstacles_;                ///< where there are any with loads
  std::optional<BodiesWriter> bodies_;                     ///< if asked for
  std::map<std::filesystem::path, SampleWriter> samples_;  ///< flow.csv, coefficients.csv; likewise
  Progress progress_;
  std::optional<CycleTable> cycle_table_;  ///< where there are cycles to measure
  CycleObserver cycles_;
  Balance balance_;
  std::vector<Observer*> all_;  ///< in the order of their calls
};

/// Whether a run begins at step 0, at the newest checkpoint of its directory, or at that of another run.
enum class Beginning { fresh, resumed, branched };

/// State of a run: what its solvers saved, and what it keeps itself.
struct Snapshot {
  std::optional<FoundCheckpoint> states;  ///< none at step 0: the case has it
  DrivingProtocol driving;
};

/// Runs one case from connecting its components to the summary, and leaves a complete run directory.
///
/// Legal call order: run, or: open -> { advance | save -> … -> restore | write_checkpoint }* -> [finish]
class CaseRun {
 public:
  using OnReady = std::function<void(const std::map<std::string, Capabilities>& components, std::int64_t step)>;

  /// References must outlive this object.
  CaseRun(const LoadedCase& loaded, const RunDirectory& directory, Components& components, Events& events,
          RunSignals& signals)
      : loaded_(loaded),
        directory_(directory),
        components_(components),
        events_(events),
        signals_(signals),
        driving_(loaded.assembly.drive, loaded.assembly.prescribed) {}

  /// @param branch    where a run starts that is Beginning::branched
  /// @param on_ready  called with the first step, once both components are connected and the checkpoint was found
  /// @throws what a component, the disk or a signal makes fail; the caller reports it
  void run(Beginning beginning, const std::optional<Branch>& branch, const OnReady& on_ready);

  /// Everything before the first step of a run that begins at step 0 or at its newest checkpoint.
  void open(bool resumes, const OnReady& on_ready);
  /// Advances to the start of step `stop`, or of the first step before which `pause` returns true.
  void advance(std::int64_t stop, const std::function<bool(std::int64_t step)>& pause) { scheme_->run(stop, pause); }
  /// Saves the solvers' states in a new folder. @throws CaseError that names a component which cannot return to them
  Snapshot save(const std::filesystem::path& folder);
  /// Continues from what `save` returned, as a run that is resumed: with new solvers, and tables that end there. Legal
  /// after a failure, too.
  void restore(const Snapshot& snapshot);
  /// Writes a checkpoint of the run directory; not at step 0, where there is nothing to save. @throws likewise
  void write_checkpoint();
  /// The swimmers' part of the summary, as if the run ended here.
  [[nodiscard]] nlohmann::ordered_json cycles();
  /// Writes the summary, and completes all files.
  void finish();

  [[nodiscard]] const SerialExplicit& scheme() const { return *scheme_; }
  [[nodiscard]] DrivingProtocol& driving() { return driving_; }

  /// Step that was being computed; −1 before the first. Meaningful after a failure too.
  [[nodiscard]] std::int64_t step() const { return step_; }

  /// What was reported to the user on the way: features that a component neglects, checkpoints left out, …
  [[nodiscard]] const std::vector<std::string>& notices() const { return notices_; }

 private:
  [[nodiscard]] FoundCheckpoint find_checkpoint(const CheckpointStore& store, std::optional<std::int64_t> step);
  [[nodiscard]] CheckpointStore own_checkpoints() const;
  void require_own_samples(const Branch& branch, std::int64_t step) const;
  void require_same_components(const CouplerState& state) const;
  void notice(const std::string& text);
  void connect();
  /// @param resumes  whether what was measured up to the checkpoint counts; if not, it is measured from there on
  void start(const std::optional<FoundCheckpoint>& checkpoint, bool resumes, const OnReady& on_ready);
  void require_announced(std::initializer_list<const char*> features) const;
  void check_features(const Capabilities& capabilities, const std::set<std::string>& required);
  /// By the name of each: "fluid", "body", and those of the controllers.
  [[nodiscard]] std::map<std::string, Capabilities> capabilities() const;
  [[nodiscard]] SolversByFile solvers() const;
  [[nodiscard]] Controllers make_controllers(const std::optional<FoundCheckpoint>& checkpoint, bool resumes);
  void make_solvers(BodySetup body, const std::optional<FoundCheckpoint>& checkpoint);
  void make_scheme(const std::optional<FoundCheckpoint>& checkpoint, bool resumes);
  void compute(const CheckpointStore& store);
  [[nodiscard]] CouplerState state();

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
  DrivingProtocol driving_;
  std::string trace_directory_;
  bool lowers_ = false;  ///< the body component lacks the case's actuators and is driven by world forces
  std::int64_t first_of_run_ = 0;
  std::optional<Plausibility> plausibility_;
  std::optional<RunObservers> observers_;
  std::optional<SerialExplicit> scheme_;
  RunTiming timing_;
  Stopwatch::Clock::time_point start_;
  std::int64_t step_ = -1;
  std::vector<std::string> notices_;
};

}  // namespace copepod::coupler
