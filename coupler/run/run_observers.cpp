#include "run/run_observers.hpp"

#include <algorithm>

#include "analysis/groups.hpp"

namespace copepod::coupler {
namespace {

std::vector<std::string> body_names(const Assembly& assembly) {
  std::vector<std::string> names;
  for (const BodySpecification& body : assembly.bodies) names.push_back(body.name);
  return names;
}

bool have_cycles(const std::vector<Group>& groups) {
  return std::any_of(groups.begin(), groups.end(), [](const Group& group) { return group.period_steps > 0; });
}

}  // namespace

RunObservers::RunObservers(const LoadedCase& loaded, const RunDirectory& directory, Events& events,
                           std::int64_t first_step, std::int64_t& step)
    : keeper_(step),
      trajectory_(directory.trajectory().string(), body_names(loaded.assembly), loaded.content.step_s,
                  loaded.content.output.trajectory_every_steps, first_step, loaded.content.output.trajectory_from_step),
      progress_(events, loaded.content.steps),
      cycles_(groups_of(loaded.content, loaded.assembly)) {
  if (have_cycles(cycles_.groups())) {
    cycle_table_.emplace(directory.cycles().string(), cycles_.groups(), loaded.content.fluid, loaded.content.step_s,
                         first_step);
    cycles_.write_to(*cycle_table_);
  }
  all_.add(keeper_);
  all_.add(trajectory_);
  all_.add(cycles_);
  all_.add(progress_);
}

void RunObservers::sync_files() {
  trajectory_.sync();
  if (cycle_table_) cycle_table_->sync();
}

}  // namespace copepod::coupler
