#include "run/run_case.hpp"

#include <chrono>
#include <limits>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "analysis/swimmer_report.hpp"
#include "config/checks/checks.hpp"
#include "config/sections/sections.hpp"
#include "config/setups.hpp"
#include "driving/prescribed_bodies.hpp"
#include "recording/recorder.hpp"
#include "run/run_observers.hpp"
#include "run/summary.hpp"
#include "scheme/serial_explicit.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {
namespace {

std::int64_t first_step(const std::optional<FoundCheckpoint>& checkpoint) {
  return checkpoint ? checkpoint->state.step : 0;
}

}  // namespace

void CaseRun::run(Beginning beginning, const std::optional<Branch>& branch,
                  const std::function<void(const Capabilities&, const Capabilities&, std::int64_t)>& on_ready) {
  const CheckpointStore store(directory_.checkpoints(), case_key(loaded_.content));
  events_.phase("handshake");
  components_.connect();
  std::optional<FoundCheckpoint> checkpoint;
  if (beginning == Beginning::resumed) checkpoint = find_checkpoint(store, std::nullopt);
  if (beginning == Beginning::branched) {
    checkpoint = find_checkpoint(CheckpointStore(branch->directory / "checkpoints", branch->case_key), branch->step);
    checkpoint->state.first_step = checkpoint->state.step;
    require_own_samples(*branch, checkpoint->state.step);
  }
  on_ready(components_.fluid_capabilities(), components_.body_capabilities(), first_step(checkpoint));
  check_features(components_.fluid_capabilities(), required_of_fluid(loaded_.content, loaded_.assembly));
  const BodySetup setup = make_body_setup(loaded_.content, loaded_.assembly);
  const Capabilities& body = components_.body_capabilities();
  const bool lowers = must_be_lowered(required_of_body(loaded_.content, setup), body.features);
  check_features(body, required_of_body(loaded_.content, lowers ? lowered(setup) : setup));
  if (lowers) {
    notice(body.name + " " + body.version +
           " has no actuators that follow its bodies (actuator:pair_force and others): the coupler sends forces along "
           "the directions at the start of each step, which is of first order in the step.");
  }
  make_solvers(setup, lowers, checkpoint);
  compute(beginning, store, checkpoint);
}

void CaseRun::check_features(const Capabilities& capabilities, const std::set<std::string>& required) {
  for (const std::string& text : require_features(capabilities, required)) notice(text);
}

void CaseRun::notice(const std::string& text) {
  spdlog::warn(text);
  events_.notice(text);
  notices_.push_back(text);
}

/// The components are there already: reading a large checkpoint takes longer than they would wait.
FoundCheckpoint CaseRun::find_checkpoint(const CheckpointStore& store, std::optional<std::int64_t> wanted) {
  FoundCheckpoint found;
  components_.stay_in_touch_during([&] { found = store.find(wanted); });
  for (const std::string& reason : found.skipped) notice(reason);
  require_same_components(found.state);
  const std::int64_t step = found.state.step, steps = loaded_.content.steps;
  if (step >= steps) {
    throw CaseError("run.steps is " + std::to_string(steps) + ", and the newest checkpoint is of step " +
                    std::to_string(step) + " (nothing is left to compute). Set run.steps to more than " +
                    std::to_string(step) + ", or run without --resume.");
  }
  notice_missing_samples(found.state);
  spdlog::info("resuming at step {}", step);
  return found;
}

/// A mean is of one case: samples of steps before a branch are those of another.
void CaseRun::require_own_samples(const Branch& branch, std::int64_t step) const {
  const FieldOutput& fields = loaded_.content.output.fields;
  if (branch.changed.empty() || fields.mean_start >= step || fields.mean_stop <= step) return;
  throw CaseError("output.fields.mean_over_steps starts at " + std::to_string(fields.mean_start) +
                  ", before the branch at step " + std::to_string(step) + " (its samples so far are of another case, " +
                  branch.changed.begin()->first + " differs). Start it at " + std::to_string(step) + " or later.");
}

/// A component reads its own checkpoints only.
void CaseRun::require_same_components(const CouplerState& state) const {
  const auto require = [&](const std::string& role, const std::string& writer, const std::string& reader) {
    if (writer.empty() || writer == reader) return;
    throw StorageError("the checkpoint of step " + std::to_string(state.step) + " was written by the " + role +
                       " component " + writer + ", which is now " + reader +
                       " (a component reads its own checkpoints only). Resume with " + writer +
                       ", or start a new run with another --out.");
  };
  require("fluid", state.fluid_component, components_.fluid_capabilities().name);
  require("body", state.body_component, components_.body_capabilities().name);
}

/// A run may be resumed with another mean field; the fluid then starts its sums anew.
void CaseRun::notice_missing_samples(const CouplerState& state) {
  const OutputCase& output = loaded_.content.output;
  const bool has_begun = output.fields.mean_stop > 0 && output.fields.mean_start < state.step;
  if (!has_begun || state.mean == mean_sampling(output)) return;
  notice("The mean field lacks its samples up to step " + std::to_string(state.step) +
         " (the previous run used others). Resume with its output.fields, or start again.");
}

void CaseRun::make_solvers(BodySetup body, bool lowers, const std::optional<FoundCheckpoint>& checkpoint) {
  events_.phase("configuring");
  const std::int64_t first = first_step(checkpoint);
  FluidSetup fluid = make_fluid_setup(loaded_.content, loaded_.assembly, directory_.root().string());
  const Capabilities& capabilities = components_.fluid_capabilities();
  if (fluid.film_thickness_m > 0.0 && !capabilities.features.contains("thin_films")) {
    fluid.film_thickness_m = 0.0;
    notice(capabilities.name + " " + capabilities.version +
           " does not leave thin films out of its loads (thin_films): the coupler adds no lubrication.");
  }
  if (loaded_.content.output.trace) {
    body.trace_directory = fluid.trace_directory = directory_.new_trace_folder().string();
    recording::open_timeline(timeline_, fluid.trace_directory, "coupler", 0);
  }
  BodySetup all = body;  // with the prescribed bodies, which the component does not have
  all.bodies = loaded_.assembly.bodies;
  all.joints = loaded_.assembly.joints;
  const VirtualMasses masses = virtual_masses(loaded_.content, loaded_.assembly);
  virtual_mass_ = VirtualMass(all, masses.mass_kg, masses.averaging, masses.returns);
  all = virtual_mass_.enlarged(all);
  lubrication_ = Lubrication(fluid, all, loaded_.content.lubrication.roughness_m);
  BodySetup sent = lowers ? lowered(body) : body;
  auto enlarged = all.bodies.cbegin();
  for (BodySpecification& each : sent.bodies) {  // in the order of all
    while (enlarged->name != each.name) ++enlarged;
    each.mass_kg = enlarged->mass_kg;
    each.inertia_kg_m2 = enlarged->inertia_kg_m2;
  }
  body_ = components_.make_body(sent, first);
  if (lowers) body_ = std::make_unique<LoweredBodies>(std::move(body_), body);
  const auto& [bodies, prescribed] = std::tie(loaded_.assembly.bodies, loaded_.assembly.prescribed);
  if (!prescribed.empty()) body_ = std::make_unique<PrescribedBodies>(std::move(body_), bodies, prescribed, body);
  fluid_ = components_.make_fluid(fluid, first);
  if (!checkpoint) return;
  body_->restore(checkpoint->body_path.string());
  fluid_->restore(checkpoint->fluid_path.string());
}

/// A branch has tables and measured cycles of its own.
void CaseRun::compute(Beginning beginning, const CheckpointStore& store,
                      const std::optional<FoundCheckpoint>& checkpoint) {
  using Clock = std::chrono::steady_clock;
  const Case& the_case = loaded_.content;
  const DrivingProtocol driving(loaded_.assembly.drive);
  const CouplerState* resumed = beginning == Beginning::resumed ? &checkpoint->state : nullptr;
  RunObservers observers(loaded_, directory_, events_, resumed, step_);
  const double largest_speed_m_per_s = on_lattice(the_case)
                                           ? largest_speed_lu * the_case.fluid.cell_size_m / the_case.step_s
                                           : std::numeric_limits<double>::infinity();
  const Plausibility plausibility(the_case.fluid, loaded_.assembly.bodies, largest_speed_m_per_s);
  SerialExplicit scheme(*fluid_, *body_, driving, plausibility, the_case.load_averaging, observers, timeline_,
                        virtual_mass_, lubrication_);
  if (checkpoint) {
    scheme.restore(checkpoint->state.step, checkpoint->state.previous_loads, checkpoint->state.previous_kinematics);
  }
  if (resumed != nullptr) {
    observers.cycles().restore(resumed->swimmers, resumed->step, resumed->first_step);
    observers.balance().restore(resumed->balance);
  }
  const bool able = components_.fluid_capabilities().features.contains("checkpoint") &&
                    components_.body_capabilities().features.contains("checkpoint");
  Checkpointer checkpointer(store, components_, able ? Checkpointer::Ability::saves : Checkpointer::Ability::none,
                            the_case, scheme.step(), checkpoint ? checkpoint->state.first_step : 0, signals_, events_);

  events_.phase("running");
  spdlog::info("running steps {} to {} of {}", scheme.step(), the_case.steps, the_case.name);
  RunTiming timing;
  timing.first_step = scheme.step();
  const Clock::time_point start = Clock::now();
  const auto ended = [&] {
    return scheme.step() >= the_case.steps ||
           (the_case.until_periodic && observers.cycles().is_periodic(the_case.until_periodic->tolerance));
  };
  const auto pause = [&](std::int64_t step) { return checkpointer.wants_pause(step) || ended(); };
  while (!ended()) {
    scheme.run(the_case.steps, pause);
    if (!ended()) checkpointer.write(*fluid_, *body_, scheme, observers);
  }
  SolverSummary fluid_summary = fluid_->summarise();  // answered after the last bulk update
  timing.loop_s = std::chrono::duration<double>(Clock::now() - start).count();
  timing.fluid_wait_s = scheme.fluid_wait_s();
  timing.body_wait_s = scheme.body_wait_s();
  scheme.finish();

  events_.phase("finishing");
  auto analysis = swimmer_reports(the_case, observers.cycles());
  analysis["balance"] = observers.balance().report();
  if (the_case.until_periodic)
    analysis["periodic"] = observers.cycles().is_periodic(the_case.until_periodic->tolerance);
  if (fluid_summary.momentum_drift) *fluid_summary.momentum_drift += observers.balance().withheld();
  const auto summary =
      make_summary(the_case, scheme.step(), fluid_summary, body_->summarise(), scheme.kinematics(), timing, analysis);
  components_.finish();
  timeline_.close();
  write_durably(directory_.summary(), summary.dump(2) + "\n");
  spdlog::info("finished after {:.1f} s", timing.loop_s);
}

}  // namespace copepod::coupler
