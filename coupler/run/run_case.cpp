#include "run/run_case.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "analysis/coefficients.hpp"
#include "analysis/swimmer_figures.hpp"
#include "config/checks/checks.hpp"
#include "config/sections/sections.hpp"
#include "config/setups.hpp"
#include "driving/prescribed_bodies.hpp"
#include "recording/recorder.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {

void CaseRun::run(Beginning beginning, const std::optional<Branch>& branch, const OnReady& on_ready) {
  const CheckpointStore store = own_checkpoints();
  connect();
  std::optional<FoundCheckpoint> checkpoint;
  if (beginning == Beginning::resumed) checkpoint = find_checkpoint(store, std::nullopt);
  if (beginning == Beginning::branched) {
    checkpoint = find_checkpoint(CheckpointStore(branch->directory / "checkpoints", branch->case_key), branch->step);
    checkpoint->state.first_step = checkpoint->state.step;
    require_own_samples(*branch, checkpoint->state.step);
  }
  if (checkpoint && checkpoint->state.step >= loaded_.content.steps) {
    const std::string step = std::to_string(checkpoint->state.step);
    throw CaseError("run.steps is " + std::to_string(loaded_.content.steps) +
                    ", and the newest checkpoint is of step " + step +
                    " (nothing is left to compute). Set run.steps to more than " + step + ", or run without --resume.");
  }
  start(checkpoint, beginning == Beginning::resumed, on_ready);
  compute(store);
  finish();
}

void CaseRun::open(bool resumes, const OnReady& on_ready) {
  connect();
  start(resumes ? std::optional(find_checkpoint(own_checkpoints(), std::nullopt)) : std::nullopt, resumes, on_ready);
}

CheckpointStore CaseRun::own_checkpoints() const { return {directory_.checkpoints(), case_key(loaded_.content)}; }

void CaseRun::write_checkpoint() {
  require_announced({"checkpoint"});
  CheckpointStore store = own_checkpoints();
  store.prepare(solvers(), state());
  components_.stay_in_touch_during([&] { store.commit(scheme_->step()); });
}

void CaseRun::connect() {
  events_.phase("handshake");
  components_.connect();
}

void CaseRun::start(const std::optional<FoundCheckpoint>& checkpoint, bool resumes, const OnReady& on_ready) {
  on_ready(capabilities(), checkpoint ? checkpoint->state.step : 0);
  check_features(components_.fluid_capabilities(), required_of_fluid(loaded_.content, loaded_.assembly));
  const BodySetup setup = make_body_setup(loaded_.content, loaded_.assembly);
  const Capabilities& body = components_.body_capabilities();
  lowers_ = must_be_lowered(required_of_body(loaded_.content, setup), body.features);
  check_features(body, required_of_body(loaded_.content, lowers_ ? lowered(setup) : setup));
  if (lowers_) {
    notice(body.name + " " + body.version +
           " has no actuators that follow its bodies (actuator:pair_force and others): the coupler sends forces along "
           "the directions at the start of each step, which is of first order in the step.");
  }
  events_.phase("configuring");
  make_solvers(setup, checkpoint);
  make_scheme(checkpoint, resumes);
}

void CaseRun::require_announced(std::initializer_list<const char*> features) const {
  for (const auto& [name, component] : capabilities())
    for (const std::string feature : features)
      if (!component.features.contains(feature))
        throw CaseError("the " + name + " component " + component.name + " cannot do that (it does not announce «" +
                        feature + "»). Do without, or see docs/adding_a_component.md.");
}

void CaseRun::check_features(const Capabilities& capabilities, const std::set<std::string>& required) {
  for (const std::string& text : require_features(capabilities, required)) notice(text);
}

void CaseRun::notice(const std::string& text) {
  if (std::ranges::find(notices_, text) != notices_.end()) return;  // of solvers that were made before
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
  // A run may be resumed with another mean field; the fluid then starts its sums anew.
  const FieldOutput& fields = loaded_.content.output.fields;
  const bool has_begun = fields.mean_stop > 0 && fields.mean_start < found.state.step;
  if (has_begun && found.state.mean != mean_sampling(loaded_.content.output))
    notice("The mean field lacks its samples up to step " + std::to_string(found.state.step) +
           " (the previous run used others). Resume with its output.fields, or start again.");
  spdlog::info("resuming at step {}", found.state.step);
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

void CaseRun::make_solvers(BodySetup body, const std::optional<FoundCheckpoint>& checkpoint) {
  const std::int64_t first = checkpoint ? checkpoint->state.step : 0;
  FluidSetup fluid = make_fluid_setup(loaded_.content, loaded_.assembly, directory_.root().string());
  if (checkpoint) fluid.initial_flow = {};  // a run that is resumed needs no file
  const Capabilities& capabilities = components_.fluid_capabilities();
  if (fluid.film_thickness_m > 0.0 && !capabilities.features.contains("thin_films")) {
    fluid.film_thickness_m = 0.0;
    notice(capabilities.name + " " + capabilities.version +
           " does not leave thin films out of its loads (thin_films): the coupler adds no lubrication.");
  }
  if (loaded_.content.output.trace) {
    trace_directory_ = body.trace_directory = fluid.trace_directory = directory_.new_trace_folder().string();
    recording::open_timeline(timeline_, trace_directory_, "coupler", 0);
  }
  BodySetup all = body;  // with the prescribed bodies, which the component does not have
  all.bodies = loaded_.assembly.bodies;
  all.joints = loaded_.assembly.joints;
  const VirtualMasses masses = virtual_masses(loaded_.content, loaded_.assembly);
  virtual_mass_ = VirtualMass(all, masses.mass_kg, masses.averaging, masses.returns);
  all = virtual_mass_.enlarged(all);
  lubrication_ = Lubrication(fluid, all, loaded_.content.lubrication.roughness_m);
  BodySetup sent = lowers_ ? lowered(body) : body;
  auto enlarged = all.bodies.cbegin();
  for (BodySpecification& each : sent.bodies) {  // in the order of all
    while (enlarged->name != each.name) ++enlarged;
    each.mass_kg = enlarged->mass_kg;
    each.inertia_kg_m2 = enlarged->inertia_kg_m2;
  }
  body_ = components_.make_body(sent, first);
  if (lowers_) body_ = std::make_unique<LoweredBodies>(std::move(body_), body);
  const auto& [bodies, prescribed] = std::tie(loaded_.assembly.bodies, loaded_.assembly.prescribed);
  if (!prescribed.empty())
    body_ = std::make_unique<PrescribedBodies>(std::move(body_), bodies, prescribed, driving_, body);
  fluid_ = components_.make_fluid(fluid, first);
  if (!checkpoint) return;
  body_->restore((checkpoint->folder / body_file).string());
  fluid_->restore((checkpoint->folder / fluid_file).string());
}

std::map<std::string, Capabilities> CaseRun::capabilities() const {
  std::map<std::string, Capabilities> all{{"fluid", components_.fluid_capabilities()},
                                          {"body", components_.body_capabilities()}};
  const std::vector<ControllerCase>& controllers = loaded_.content.controllers;
  for (std::size_t i = 0; i < controllers.size(); ++i)
    all.emplace(controllers[i].name, components_.controller_capabilities(i));
  return all;
}

SolversByFile CaseRun::solvers() const {
  SolversByFile all{{fluid_file, fluid_.get()}, {body_file, body_.get()}};
  const std::vector<AttachedController>& attached = scheme_->controllers().all();
  for (std::size_t i = 0; i < attached.size(); ++i)
    all.emplace_back(controller_file(loaded_.content.controllers[i].name), attached[i].controller.get());
  return all;
}

/// A branch may have other controllers than the run that it starts from: those begin anew. What others have steered
/// follows the case again there; in a run that is resumed it stays.
Controllers CaseRun::make_controllers(const std::optional<FoundCheckpoint>& checkpoint, bool resumes) {
  std::vector<AttachedController> all;
  const std::size_t actuators = loaded_.assembly.drive.size();
  const bool knows_drive = checkpoint && checkpoint->state.steered.size() == loaded_.assembly.drive_paths.size() &&
                           checkpoint->state.ways.size() == loaded_.assembly.prescribed.size();
  const auto follow = [&](std::size_t number) {
    if (!knows_drive || checkpoint->state.steered[number].empty()) return;
    driving_.follow(number, checkpoint->state.steered[number]);
    if (number >= actuators) driving_.resume_way(number - actuators, checkpoint->state.ways[number - actuators]);
  };
  for (std::size_t number = 0; resumes && number < loaded_.assembly.drive_paths.size(); ++number) follow(number);
  for (std::size_t i = 0; i < loaded_.content.controllers.size(); ++i) {
    ControllerSetup setup = make_controller_setup(loaded_.content, loaded_.assembly, i);
    if (!trace_directory_.empty()) setup.trace_directory = trace_directory_;
    all.push_back(attached(components_.make_controller(i, setup, checkpoint ? checkpoint->state.step : 0), setup,
                           loaded_.assembly));
    if (!checkpoint) continue;
    const std::filesystem::path file = checkpoint->folder / controller_file(setup.name);
    if (std::filesystem::exists(file)) all.back().controller->restore(file.string());
    for (const auto& [number, factor, moves] : all.back().actuators) follow(number);
  }
  return {std::move(all), driving_};
}

/// A branch has tables and measured cycles of its own.
void CaseRun::make_scheme(const std::optional<FoundCheckpoint>& checkpoint, bool resumes) {
  const Case& the_case = loaded_.content;
  const CouplerState* resumed = resumes ? &checkpoint->state : nullptr;
  observers_.emplace(loaded_, directory_, events_, resumed, step_);
  const double largest_speed_m_per_s = on_lattice(the_case)
                                           ? largest_speed_lu * the_case.fluid.cell_size_m / the_case.step_s
                                           : std::numeric_limits<double>::infinity();
  plausibility_.emplace(the_case.fluid, loaded_.assembly.bodies, largest_speed_m_per_s);
  scheme_.emplace(*fluid_, *body_, driving_, *plausibility_, the_case.load_averaging, *observers_, timeline_,
                  virtual_mass_, lubrication_, make_controllers(checkpoint, resumes));
  if (checkpoint) {
    const CouplerState& state = checkpoint->state;
    scheme_->restore(state.step, state.previous_loads, state.previous_kinematics, state.loads);
    first_of_run_ = checkpoint->state.first_step;
  }
  if (resumed != nullptr) {
    observers_->cycles().restore(resumed->swimmers, resumed->step, resumed->first_step);
    observers_->balance().restore(resumed->balance);
  }
  timing_.first_step = scheme_->step();
  start_ = Stopwatch::Clock::now();
}

void CaseRun::compute(const CheckpointStore& store) {
  const Case& the_case = loaded_.content;
  const bool able =
      std::ranges::all_of(capabilities(), [](const auto& each) { return each.second.features.contains("checkpoint"); });
  Checkpointer checkpointer(store, components_, able ? Checkpointer::Ability::saves : Checkpointer::Ability::none,
                            the_case, scheme_->step(), signals_, events_);
  events_.phase("running");
  spdlog::info("running steps {} to {} of {}", scheme_->step(), the_case.steps, the_case.name);
  const auto ended = [&] {
    return scheme_->step() >= the_case.steps ||
           (the_case.until_periodic && observers_->cycles().is_periodic(the_case.until_periodic->tolerance));
  };
  while (!ended()) {
    scheme_->run(the_case.steps, [&](std::int64_t step) { return checkpointer.wants_pause(step) || ended(); });
    if (!ended()) checkpointer.write(solvers(), scheme_->step(), [&] { return state(); });
  }
}

CouplerState CaseRun::state() {
  return {scheme_->step(),
          first_of_run_,
          scheme_->previous_loads(),
          scheme_->previous_kinematics(),
          observers_->cycles().sums(),
          observers_->balance().sums(),
          observers_->sync_files(),
          mean_sampling(loaded_.content.output),
          scheme_->loads(),
          driving_.steered(),
          driving_.ways(),
          components_.fluid_capabilities().name,
          components_.body_capabilities().name};
}

Snapshot CaseRun::save(const std::filesystem::path& folder) {
  require_announced({"checkpoint", "snapshots"});
  if (scheme_->step() == 0) return {std::nullopt, driving_};
  for (const auto& [name, solver] : solvers()) solver->save((folder / name).string());
  return {FoundCheckpoint{folder, state(), {}}, driving_};
}

void CaseRun::restore(const Snapshot& snapshot) {
  scheme_.reset();
  observers_.reset();  // completes its files, which the next one shortens
  fluid_.reset();
  body_.reset();
  driving_ = snapshot.driving;
  make_solvers(make_body_setup(loaded_.content, loaded_.assembly), snapshot.states);
  make_scheme(snapshot.states, snapshot.states.has_value());
}

nlohmann::ordered_json CaseRun::cycles() {
  CycleObserver cycles = observers_->cycles();
  cycles.write_to(nullptr);
  scheme_->finish_to(cycles);
  return swimmer_reports(loaded_.content, cycles);
}

void CaseRun::finish() {
  const Case& the_case = loaded_.content;
  SolverSummary fluid_summary = fluid_->summarise();  // answered after the last bulk update
  timing_.loop_s = std::chrono::duration<double>(Stopwatch::Clock::now() - start_).count();
  timing_.fluid_wait_s = scheme_->fluid_wait_s();
  timing_.body_wait_s = scheme_->body_wait_s();
  scheme_->finish();

  events_.phase("finishing");
  auto analysis = swimmer_reports(the_case, observers_->cycles());
  if (!the_case.output.coefficients.empty())
    analysis["coefficients"] = coefficient_report(directory_.coefficients(), the_case);
  const FlowSampling flow = make_fluid_setup(the_case, loaded_.assembly, "").flow;
  if (flow.every_steps > 0 && the_case.output.writes_flow)
    analysis["flow"] = flow_report(directory_.flow(), flow.names(), the_case.output.flow_from_step);
  analysis["balance"] = observers_->balance().report();
  if (std::ranges::any_of(the_case.fluid.boundaries, &Boundary::removes_bodies)) {
    analysis["removed_bodies"] = nlohmann::ordered_json::array();
    for (Eigen::Index body = 0; body < scheme_->kinematics().bodies(); ++body)
      if (plausibility_->is_removed(scheme_->kinematics().position_m.col(body)))
        analysis["removed_bodies"].push_back(loaded_.assembly.bodies[body].name);
  }
  if (the_case.until_periodic)
    analysis["periodic"] = observers_->cycles().is_periodic(the_case.until_periodic->tolerance);
  if (fluid_summary.momentum_drift) *fluid_summary.momentum_drift += observers_->balance().withheld();
  const auto summary = make_summary(the_case, scheme_->step(), fluid_summary, body_->summarise(), scheme_->kinematics(),
                                    timing_, analysis);
  components_.finish();
  timeline_.close();
  write_durably(directory_.summary(), summary.dump(2) + "\n");
  spdlog::info("finished after {:.1f} s", timing_.loop_s);
}

}  // namespace copepod::coupler
