#include "run/run_observers.hpp"

#include <nlohmann/json.hpp>

#include "analysis/swimmer_report.hpp"
#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

std::vector<std::string> body_names(const Assembly& assembly) {
  std::vector<std::string> names;
  for (const BodySpecification& body : assembly.bodies) names.push_back(body.name);
  return names;
}

}  // namespace

RunObservers::RunObservers(const LoadedCase& loaded, const RunDirectory& directory, Events& events,
                           std::int64_t first_step, std::int64_t& step)
    : case_(loaded.content),
      keeper_(step),
      trajectory_(directory.trajectory().string(), body_names(loaded.assembly), case_.step_s,
                  case_.output.trajectory_every_steps, first_step, case_.output.trajectory_from_step),
      progress_(events, case_.steps) {
  all_.add(keeper_);
  all_.add(trajectory_);
  for (std::size_t i = 0; i < case_.swimmers.size(); ++i) {
    swimmers_.push_back(std::make_unique<SwimmerObserver>(case_.swimmers[i], loaded.assembly.first_bodies[i]));
    all_.add(*swimmers_.back());
  }
  all_.add(progress_);
}

nlohmann::ordered_json RunObservers::swimmer_reports() const {
  nlohmann::ordered_json reports = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < swimmers_.size(); ++i) {
    reports.push_back(swimmer_report(case_.swimmers[i], *swimmers_[i], case_));
  }
  return reports;
}

std::vector<PeriodSums> RunObservers::sums() const {
  std::vector<PeriodSums> sums;
  for (const auto& swimmer : swimmers_) sums.push_back(swimmer->sums());
  return sums;
}

void RunObservers::restore(const std::vector<PeriodSums>& sums) {
  if (sums.size() != swimmers_.size()) {
    throw StorageError("the checkpoint has the analysis of " + std::to_string(sums.size()) + " swimmers, the case " +
                       std::to_string(swimmers_.size()) + " (it is of another case). Use another run directory.");
  }
  for (std::size_t i = 0; i < sums.size(); ++i) swimmers_[i]->restore(sums[i]);
}

}  // namespace copepod::coupler
