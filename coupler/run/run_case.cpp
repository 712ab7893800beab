#include "run/run_case.hpp"

#include <chrono>
#include <memory>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "analysis/swimmer_observer.hpp"
#include "analysis/swimmer_report.hpp"
#include "config/setups.hpp"
#include "observers/progress.hpp"
#include "observers/trajectory_writer.hpp"
#include "run/summary.hpp"
#include "scheme/serial_explicit.hpp"

namespace copepod::coupler {
namespace {

std::vector<std::string> body_names(const Assembly& assembly) {
  std::vector<std::string> names;
  for (const BodySpecification& body : assembly.bodies) names.push_back(body.name);
  return names;
}

/// Remembers how far a run came, for the report of a failure.
class StepKeeper final : public Observer {
 public:
  explicit StepKeeper(std::int64_t& step) : step_(step) {}
  void observe(const StepRecord& record) override { step_ = record.step; }
  void finish(const StepRecord& last) override { step_ = last.step; }

 private:
  std::int64_t& step_;
};

/// Everybody who looks at a run.
class Audience {
 public:
  Audience(const LoadedCase& loaded, const RunDirectory& directory, Events& events, std::int64_t& step)
      : case_(loaded.content),
        keeper_(step),
        trajectory_(directory.trajectory().string(), body_names(loaded.assembly), case_.step_s,
                    case_.output.trajectory_every_steps),
        progress_(events, case_.steps) {
    all_.add(keeper_);
    all_.add(trajectory_);
    for (std::size_t i = 0; i < case_.swimmers.size(); ++i) {
      swimmers_.push_back(std::make_unique<SwimmerObserver>(case_.swimmers[i], first_body_of_swimmer(i)));
      all_.add(*swimmers_.back());
    }
    all_.add(progress_);
  }

  Observer& all() { return all_; }
  [[nodiscard]] nlohmann::ordered_json swimmer_reports() const {
    nlohmann::ordered_json reports = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < swimmers_.size(); ++i) {
      reports.push_back(swimmer_report(case_.swimmers[i], *swimmers_[i], case_));
    }
    return reports;
  }

 private:
  const Case& case_;
  StepKeeper keeper_;
  TrajectoryWriter trajectory_;
  Progress progress_;
  std::vector<std::unique_ptr<SwimmerObserver>> swimmers_;
  Observers all_;
};

}  // namespace

CaseRun::CaseRun(const LoadedCase& loaded, const RunDirectory& directory, Components& components,
                 Events& events, const std::atomic<int>& stop_signal)
    : loaded_(loaded),
      directory_(directory),
      components_(components),
      events_(events),
      stop_signal_(stop_signal) {}

void CaseRun::run(const std::function<void(const Capabilities&, const Capabilities&)>& on_connected) {
  using Clock = std::chrono::steady_clock;
  const Case& the_case = loaded_.content;
  events_.phase("handshake");
  components_.connect();
  on_connected(components_.fluid_capabilities(), components_.body_capabilities());
  require_features(components_.fluid_capabilities(), required_of_fluid(the_case, loaded_.assembly));
  require_features(components_.body_capabilities(), required_of_body(the_case, loaded_.assembly));

  events_.phase("configuring");
  const auto body = components_.make_body(make_body_setup(the_case, loaded_.assembly), 0);
  const auto fluid =
      components_.make_fluid(make_fluid_setup(the_case, loaded_.assembly, directory_.root().string()), 0);
  const DrivingProtocol driving(loaded_.assembly.driving,
                                static_cast<Eigen::Index>(loaded_.assembly.bodies.size()));
  Audience audience(loaded_, directory_, events_, step_);
  SerialExplicit scheme(*fluid, *body, driving, the_case.load_averaging, audience.all());

  events_.phase("running");
  spdlog::info("running {} steps of {}", the_case.steps, the_case.name);
  const Clock::time_point start = Clock::now();
  scheme.run(the_case.steps, &stop_signal_);
  const SolverSummary fluid_summary = fluid->summarise();  // answered after the last bulk update
  RunTiming timing;
  timing.loop_s = std::chrono::duration<double>(Clock::now() - start).count();
  timing.fluid_wait_s = scheme.fluid_wait_s();
  timing.body_wait_s = scheme.body_wait_s();
  scheme.finish();

  events_.phase("finishing");
  const auto summary = make_summary(the_case, scheme.step(), fluid_summary, body->summarise(),
                                    scheme.kinematics(), timing, audience.swimmer_reports());
  components_.finish();
  write_atomically(directory_.summary(), summary.dump(2) + "\n");
  spdlog::info("finished after {:.1f} s", timing.loop_s);
}

}  // namespace copepod::coupler
