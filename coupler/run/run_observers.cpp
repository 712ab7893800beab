#include <algorithm>
#include <iterator>

#include "analysis/coefficients.hpp"
#include "config/setups.hpp"
#include "run/run_case.hpp"

namespace copepod::coupler {
namespace {

std::vector<ObstacleSpecification> obstacles_with_loads(const LoadedCase& loaded) {
  std::vector<ObstacleSpecification> found;
  std::ranges::copy_if(loaded.content.fluid.obstacles, std::back_inserter(found), &ObstacleSpecification::loads);
  return found;
}

/// Where to continue a table; one that the checkpoint lacks cannot be continued: this end fits no file.
std::optional<TableEnd> end_of(const std::filesystem::path& table, const CouplerState* resumed) {
  if (resumed == nullptr) return std::nullopt;
  const auto found = resumed->tables.find(table.filename().string());
  return found == resumed->tables.end() ? TableEnd{} : found->second;
}

/// A resumed run continues in the form in which it began.
std::filesystem::path trajectory_of(const LoadedCase& loaded, const RunDirectory& directory,
                                    const CouplerState* resumed) {
  const bool is_csv = resumed != nullptr ? resumed->tables.contains(directory.trajectory_csv().filename().string())
                                         : loaded.content.output.trajectory_format == TrajectoryFormat::csv;
  return is_csv ? directory.trajectory_csv() : directory.trajectory_npy();
}

/// Of bodies or obstacles.
template <class Item>
std::unique_ptr<TrajectoryWriter> writer_of(const std::vector<Item>& items, const std::filesystem::path& path,
                                            const LoadedCase& loaded, const CouplerState* resumed) {
  std::vector<std::string> names(items.size());
  std::ranges::transform(items, names.begin(), &Item::name);
  const OutputCase& output = loaded.content.output;
  return std::make_unique<TrajectoryWriter>(path.string(), names, loaded.content.step_s, output.trajectory_every_steps,
                                            output.trajectory_from_step, end_of(path, resumed));
}

}  // namespace

RunObservers::RunObservers(const LoadedCase& loaded, const RunDirectory& directory, Events& events,
                           const CouplerState* resumed, std::int64_t& step)
    : directory_(directory),
      step_(step),
      trajectory_path_(trajectory_of(loaded, directory, resumed)),
      trajectory_(writer_of(loaded.assembly.bodies, trajectory_path_, loaded, resumed)),
      obstacles_path_(directory.obstacles(trajectory_path_.extension())),
      progress_(events, loaded.content.steps),
      cycles_(groups_of(loaded.content, loaded.assembly)),
      balance_(loaded.assembly.bodies, loaded.content.step_s) {
  if (have_cycles(cycles_.groups())) {
    cycle_table_.emplace(directory.cycles().string(), cycles_.groups(), loaded.content.fluid, loaded.content.step_s,
                         end_of(directory.cycles(), resumed));
    cycles_.write_to(&*cycle_table_);
  }
  if (const auto obstacles = obstacles_with_loads(loaded); !obstacles.empty())
    obstacles_.emplace(obstacles, writer_of(obstacles, obstacles_path_, loaded, resumed));
  const std::int64_t every_steps = loaded.content.output.bodies_every_steps;
  if (every_steps > 0 && !loaded.assembly.bodies.empty()) {
    bodies_.emplace(directory.bodies(), loaded.assembly.bodies, loaded.content.step_s,
                    make_body_setup(loaded.content, loaded.assembly).periodic_length_m, every_steps,
                    resumed == nullptr ? 0 : resumed->step);
  }
  const FlowSampling flow = make_fluid_setup(loaded.content, loaded.assembly, "").flow;
  const auto sample = [&](const std::filesystem::path& path, const std::vector<std::string>& names,
                          const SampleWriter::Values& values) {
    const bool continues = resumed != nullptr && resumed->tables.contains(path.filename().string());
    samples_.try_emplace(path, path.string(), names, loaded.content.step_s, values,
                         end_of(path, continues ? resumed : nullptr));
  };
  if (flow.every_steps > 0 && loaded.content.output.writes_flow)
    sample(directory.flow(), flow.names(), [flow](const StepRecord& record) {
      return flow.values_in(record.step) > 0 ? record.raw.flow : Eigen::VectorXd();
    });
  if (!loaded.content.output.coefficients.empty())
    sample(directory.coefficients(), coefficient_columns(loaded.content),
           [&loaded](const StepRecord& record) { return coefficients_in(record, loaded); });
  all_ = {trajectory_.get(), &cycles_, &balance_, &progress_};
  for (auto& [path, writer] : samples_) all_.push_back(&writer);
  if (bodies_) all_.insert(all_.begin() + 1, &*bodies_);
  if (obstacles_) all_.insert(all_.begin() + 1, &*obstacles_);
}

void RunObservers::observe(const StepRecord& record) {
  step_ = record.step;
  for (Observer* observer : all_) observer->observe(record);
}

void RunObservers::finish(const StepRecord& last) {
  step_ = last.step;
  for (Observer* observer : all_) observer->finish(last);
}

TableEnds RunObservers::sync_files() {
  TableEnds ends{{trajectory_path_.filename().string(), trajectory_->sync()}};
  if (obstacles_) ends[obstacles_path_.filename().string()] = obstacles_->sync();
  if (bodies_) bodies_->sync();
  for (auto& [path, writer] : samples_) ends[path.filename().string()] = writer.sync();
  if (cycle_table_) ends[directory_.cycles().filename().string()] = cycle_table_->sync();
  return ends;
}

}  // namespace copepod::coupler
