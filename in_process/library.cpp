#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <poll.h>
#include <stop_token>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/sinks/null_sink.h>

#include "c_border.hpp"
#include "config/setups.hpp"
#include "contract/words.hpp"
#include "local_components.hpp"
#include "remote/remote_solvers.hpp"
#include "run/run_case.hpp"
#include "run/summary.hpp"
#include "system/durable_file.hpp"
#include "system/process.hpp"

namespace copepod {
namespace {

namespace fs = std::filesystem;
using coupler::LoadedCase;

/// A folder that no other process is to use; the lock is that of `copepod run` on a run directory.
class FolderLock {
 public:
  FolderLock() = default;
  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  ~FolderLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  bool take(const fs::path& path) {
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    return descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
  }

 private:
  int descriptor_ = -1;
};

/// A new folder that goes with this object: in memory, where the system has such a place. Its lock shows that it is in
/// use; those of processes that were killed are removed.
class TemporaryFolder {
 public:
  /// @param shared  where to make it in place of that
  explicit TemporaryFolder(const fs::path& shared = {}) {
    const fs::path memory = ::access("/dev/shm", W_OK) == 0 ? "/dev/shm" : fs::temp_directory_path();
    const fs::path parent = shared.empty() ? memory : shared;
    for (const auto& entry : fs::directory_iterator(parent))
      if (entry.path().filename().string().starts_with(name_start)) remove_if_abandoned(entry.path());
    std::string path = parent / (name_start + std::to_string(::getpid()) + "-XXXXXX");
    if (::mkdtemp(path.data()) == nullptr || !lock_.take(path))
      throw StorageError(path + " cannot be made (" + std::generic_category().message(errno) + "). Free some space.");
    path_ = path;
  }
  TemporaryFolder(TemporaryFolder&& other) noexcept
      : path_(std::exchange(other.path_, fs::path())), lock_(std::move(other.lock_)) {}
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  inline static const std::string name_start = "copepod-simulation-";

  static void remove_if_abandoned(const fs::path& path) {
    struct stat status {};
    constexpr std::time_t young_s = 60;  // its maker may be about to lock it
    std::error_code ignored;
    FolderLock lock;
    if (::lstat(path.c_str(), &status) == 0 && status.st_uid == ::geteuid() &&
        std::time(nullptr) - status.st_mtime > young_s && lock.take(path))
      fs::remove_all(path, ignored);
  }

  fs::path path_;
  FolderLock lock_;
};

struct KeptSnapshot {
  TemporaryFolder folder;
  coupler::Snapshot snapshot;
};

/// Where services connect, if there are any, and other values of the case.
/// @param stop  receives the descriptor of --stop
coupler::Options read(const char* const* settings, int& stop) {
  coupler::Options options;
  std::vector<std::string>& overrides = options.overrides;
  for (; settings != nullptr && *settings != nullptr; ++settings) overrides.emplace_back(*settings);
  const auto taken = [&](const std::string& option) {
    const auto place = std::ranges::find_if(overrides, [&](const auto& word) { return word.starts_with(option); });
    const std::string value = place == overrides.end() ? "" : place->substr(option.size());
    if (place != overrides.end()) overrides.erase(place);
    return value;
  };
  options.endpoint = taken("--endpoint=");
  options.session = taken("--session=");
  options.key_file = taken("--keys=");
  stop = number_in<int>(taken("--stop=")).value_or(-1);
  require(options.endpoint.empty() == options.session.empty(),
          "--endpoint or --session is missing (services need both to connect). Give both, or none.");
  const std::string transport = options.endpoint.starts_with("tcp") ? options.endpoint : "ipc";
  overrides.insert(overrides.begin(), "services.transport=" + (options.endpoint.empty() ? "in_process" : transport));
  return options;
}

/// @param keeps_results  without, nothing is written on the way: it would fill the memory
LoadedCase load(const std::string& case_file, const std::vector<std::string>& overrides, bool keeps_results) {
  LoadedCase loaded = coupler::load_case(case_file, overrides);
  if (loaded.sweep) throw CaseError(case_file + " is a sweep (a simulation is of one case). Set sweep=null.");
  if (loaded.content.output.trace || loaded.content.output.wire)
    throw CaseError(
        "output.trace and output.wire are of runs that nothing interrupts (a simulation may return to an earlier "
        "state). Remove them.");
  if (!keeps_results) {
    coupler::OutputCase& output = loaded.content.output;
    output.trajectory_every_steps = output.bodies_every_steps = 0;
    output.fields.every_steps = output.fields.mean_stop = 0;
    output.writes_flow = false;
    output.coefficients.clear();
  }
  return loaded;
}

/// A case that is advanced by its caller.
class Simulation {
 public:
  /// @param resumes  the run in the directory, from its newest checkpoint
  Simulation(const std::string& case_file, const char* const* settings, const char* directory, bool resumes)
      : options_(read(settings, stop_.fd)),
        loaded_(load(case_file, options_.overrides, directory != nullptr)),
        directory_(directory != nullptr ? fs::path(directory) : temporary_.emplace().path()),
        components_(make_components()),
        provenance_(directory_, "libcopepod", "", loaded_.content.services.fluid_ranks, resumes),
        run_(loaded_, directory_, *components_, events_, signals_) {
    if (!temporary_ && !lock_.take(fs::canonical(directory_.root())) && errno == EWOULDBLOCK)
      throw CaseError(directory_.root().string() +
                      " is in use (a run or simulation writes there). Wait for it to end.");
    if (!resumes && fs::exists(directory_.resolved_case()))
      throw CaseError(directory_.root().string() +
                      " holds a run already (which would be lost). Choose another folder, "
                      "or resume it.");
    if (resumes) coupler::require_same_case(directory_.root(), loaded_.content);
    run_.open(resumes, [&](const auto& components, std::int64_t) {
      write_durably(directory_.resolved_case(), coupler::to_yaml(coupler::resolved(loaded_.content)));
      provenance_.set_components(components);
      provenance_.write();
    });
    nlohmann::ordered_json description{
        {"step_s", loaded_.content.step_s},
        {"directory", directory != nullptr ? directory_.root().string() : ""},
        {"warnings", loaded_.warnings},
        {"bodies", nlohmann::json::array()},
        {"actuators", loaded_.assembly.drive_paths},
        {"flow", coupler::make_fluid_setup(loaded_.content, loaded_.assembly, "").flow.names()}};
    for (const BodySpecification& body : loaded_.assembly.bodies) description["bodies"].push_back(body.name);
    description_ = description.dump();
    stop_.fd = -1;
    if (!options_.endpoint.empty()) heart_ = std::jthread([this](const std::stop_token& stop) { beat(stop); });
  }

  [[nodiscard]] const std::string& description() const { return description_; }

  std::int64_t step(std::int64_t steps, double limit_s) {
    using Clock = std::chrono::steady_clock;
    require(steps >= 0 && limit_s >= 0.0, "steps and limit_s must not be negative (time runs forward). Correct them.");
    require_usable();
    const Clock::time_point start = Clock::now();
    const std::int64_t first = run_.scheme().step();
    const auto pause = [&](std::int64_t next) {
      return limit_s > 0.0 && next > first && std::chrono::duration<double>(Clock::now() - start).count() >= limit_s;
    };
    const std::int64_t most = std::numeric_limits<std::int64_t>::max() - first;
    or_fail([&] { run_.advance(first + std::min(steps, most), pause); });
    return run_.scheme().step() - first;
  }

  [[nodiscard]] copepod_state observe() const {
    require_usable();
    const Kinematics& now = run_.scheme().kinematics();
    const Loads& loads = run_.scheme().loads();
    return {run_.scheme().step(),        now.bodies(),
            now.position_m.data(),       now.orientation_wxyz.data(),
            now.velocity_m_per_s.data(), now.angular_velocity_rad_per_s.data(),
            loads.force_N.data(),        loads.torque_N_m.data(),
            loads.flow.size(),           loads.flow.data()};
  }

  const std::string& cycles() {
    require_usable();
    return cycles_ = run_.cycles().dump();
  }

  void act(std::int64_t actuator, double value, std::int64_t steps) {
    const std::size_t count = loaded_.assembly.drive_paths.size();
    require(actuator >= 0 && actuator < static_cast<std::int64_t>(count),
            "actuator " + std::to_string(actuator) + " is not there (the case has " + std::to_string(count) +
                "). See copepod_describe.");
    require_usable();
    require(std::isfinite(value) && steps >= 0, "an actuator's value must be finite, its steps not negative.");
    const auto number = static_cast<std::size_t>(actuator);
    const double unit = coupler::unit_of_actuator(loaded_.assembly, number);
    run_.driving().steer(number, run_.scheme().step(), unit * value, steps);
  }

  void write_checkpoint() {
    require_usable();
    require(!temporary_ && run_.scheme().step() > 0,
            "a checkpoint cannot be written (it needs a run directory, and a first step). Open one, and step before.");
    or_keep([&] { run_.write_checkpoint(); });
  }

  std::int64_t snapshot() {
    require_usable();
    const bool over_hosts = options_.endpoint.starts_with("tcp") && !temporary_;  // which share the run directory
    TemporaryFolder folder(over_hosts ? directory_.root() : fs::path());
    coupler::Snapshot saved = or_keep([&] { return run_.save(folder.path()); });
    snapshots_.emplace(++newest_snapshot_, KeptSnapshot{std::move(folder), std::move(saved)});
    return newest_snapshot_;
  }

  void restore(std::int64_t snapshot) {
    const KeptSnapshot& kept = found(snapshot)->second;
    or_fail([&] { run_.restore(kept.snapshot); });
    failure_.reset();
  }

  void drop(std::int64_t snapshot) { snapshots_.erase(found(snapshot)); }

  void close() {
    std::exception_ptr problem;
    try {
      if (!failure_) or_fail([&] { temporary_ ? components_->finish() : run_.finish(); });
    } catch (const std::exception&) {
      problem = std::current_exception();
    }
    if (failure_) components_->abort(*failure_);
    if (!temporary_) {
      provenance_.set_notices(run_.notices());
      provenance_.write_end(failure_ ? failure_->code : ExitCode::finished, failure_ ? failure_->reason : "");
    }
    if (problem) std::rethrow_exception(problem);
  }

  std::mutex in_a_call;
  std::mutex wire;  ///< held while components are used

 private:
  std::unique_ptr<coupler::Components> make_components() {
    if (options_.endpoint.empty()) return std::make_unique<LocalComponents>(loaded_.content.services.fluid_ranks);
    return std::make_unique<coupler::RemoteComponents>(options_, loaded_.content,
                                                       [this] { return ::poll(&stop_, 1, 0) > 0 ? SIGTERM : 0; });
  }

  /// Services receive heartbeats however long the caller lets the simulation rest.
  void beat(const std::stop_token& stop) {
    block_signals();
    std::unique_lock lock(wire);
    while (!resting_.wait_for(lock, stop, std::chrono::milliseconds(400), [&] { return stop.stop_requested(); })) {
      try {
        components_->stay_in_touch_during([] {});
      } catch (const std::exception&) {  // the next call throws it again
      }
    }
  }

  void require_usable() const {
    require(!failure_, "this simulation has failed (see the message then). Restore a snapshot, or close it.");
  }

  /// After whatever is thrown only a snapshot leads back.
  template <class Action>
  void or_fail(const Action& action) {
    try {
      action();
    } catch (const std::exception& error) {
      failure_ = coupler::report_of(error, run_.step());
      throw;
    }
  }

  /// The same of a solver that fails; a disk that does not take a state, or a component that has none, changes nothing.
  template <class Action>
  std::invoke_result_t<Action> or_keep(const Action& action) {
    try {
      return action();
    } catch (const std::exception& error) {
      const FailureReport report = coupler::report_of(error, run_.step());
      if (report.code == ExitCode::solver_failed) failure_ = report;
      throw;
    }
  }

  std::map<std::int64_t, KeptSnapshot>::iterator found(std::int64_t snapshot) {
    const auto place = snapshots_.find(snapshot);
    require(place != snapshots_.end(),
            "snapshot " + std::to_string(snapshot) + " is not there (dropped, or of another simulation?). Make one.");
    return place;
  }

  pollfd stop_{-1, POLLIN, 0};  ///< ends the opening when it can be read
  coupler::Options options_;
  LoadedCase loaded_;
  std::optional<TemporaryFolder> temporary_;
  coupler::RunDirectory directory_;
  FolderLock lock_;
  std::unique_ptr<coupler::Components> components_;
  std::ostream nowhere_{nullptr};
  coupler::Events events_{nowhere_};
  coupler::RunSignals signals_;
  coupler::Provenance provenance_;
  coupler::CaseRun run_;
  std::string description_;
  std::string cycles_;
  std::optional<FailureReport> failure_;
  std::map<std::int64_t, KeptSnapshot> snapshots_;
  std::int64_t newest_snapshot_ = 0;
  std::condition_variable_any resting_;
  std::jthread heart_;
};

/// All that are open. A handle is a number, so that one that was closed is refused.
std::mutex registry_mutex;
std::map<std::int64_t, std::shared_ptr<Simulation>> registry;
std::int64_t newest_handle = 0;

/// `guarded` for a simulation that no other call uses.
template <class Action>
int guarded(std::int64_t handle, const Action& action) noexcept {
  return copepod::guarded([&] {
    std::shared_ptr<Simulation> simulation;
    {
      const std::lock_guard lock(registry_mutex);
      const auto found = registry.find(handle);
      require(found != registry.end(),
              "simulation " + std::to_string(handle) + " is not open (closed before?). Use one from copepod_open.");
      simulation = found->second;
    }
    const std::unique_lock lock(simulation->in_a_call, std::try_to_lock);
    require(lock.owns_lock(), "another thread is in a call for this simulation (one at a time). Wait for it.");
    const std::lock_guard wire(simulation->wire);
    action(*simulation);
  });
}

int opened(const char* place, const char* case_file, const char* const* settings, const char* directory, bool resumes,
           int64_t* simulation) {
  return copepod::guarded([&] {
    require_arguments(place, simulation);
    static const bool has_no_log = [] {  // the default one writes to the caller's terminal
      spdlog::set_default_logger(spdlog::create<spdlog::sinks::null_sink_mt>("copepod"));
      return true;
    }();
    static_cast<void>(has_no_log);
    const auto made = std::make_shared<Simulation>(place + std::string(case_file), settings, directory, resumes);
    const std::lock_guard lock(registry_mutex);
    registry.emplace(++newest_handle, made);
    *simulation = newest_handle;
  });
}

}  // namespace
}  // namespace copepod

using namespace copepod;

int copepod_open(const char* case_file, const char* const* settings, const char* directory, int64_t* simulation) {
  return opened(case_file, "", settings, directory, false, simulation);
}

int copepod_resume(const char* directory, const char* const* settings, int64_t* simulation) {
  return opened(directory, "/case.yaml", settings, directory, true, simulation);
}

int copepod_describe(int64_t simulation, const char** json) {
  return guarded(simulation, [&](const Simulation& found) {
    require_arguments(json);
    *json = found.description().c_str();
  });
}

int copepod_step(int64_t simulation, int64_t steps, double limit_s, int64_t* done) {
  return guarded(simulation, [&](Simulation& found) {
    const std::int64_t count = found.step(steps, limit_s);
    if (done != nullptr) *done = count;
  });
}

int copepod_observe(int64_t simulation, copepod_state* state) {
  return guarded(simulation, [&](const Simulation& found) {
    require_arguments(state);
    *state = found.observe();
  });
}

int copepod_cycles(int64_t simulation, const char** json) {
  return guarded(simulation, [&](Simulation& found) {
    require_arguments(json);
    *json = found.cycles().c_str();
  });
}

int copepod_act(int64_t simulation, int64_t actuator, double value, int64_t steps) {
  return guarded(simulation, [&](Simulation& found) { found.act(actuator, value, steps); });
}

int copepod_write_checkpoint(int64_t simulation) {
  return guarded(simulation, [](Simulation& found) { found.write_checkpoint(); });
}

int copepod_snapshot(int64_t simulation, int64_t* snapshot) {
  return guarded(simulation, [&](Simulation& found) {
    require_arguments(snapshot);
    *snapshot = found.snapshot();
  });
}

int copepod_restore(int64_t simulation, int64_t snapshot) {
  return guarded(simulation, [&](Simulation& found) { found.restore(snapshot); });
}

int copepod_drop(int64_t simulation, int64_t snapshot) {
  return guarded(simulation, [&](Simulation& found) { found.drop(snapshot); });
}

int copepod_close(int64_t simulation) {
  return guarded(simulation, [&](Simulation& found) {
    {
      const std::lock_guard lock(registry_mutex);
      registry.erase(simulation);
    }
    found.close();
  });
}

const char* copepod_error(void) { return message_of_last_failure.c_str(); }
