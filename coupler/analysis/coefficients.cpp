#include "analysis/coefficients.hpp"

#include <charconv>
#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

namespace copepod::coupler {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;

double half_span(const ArrayXd& values) { return 0.5 * (values.maxCoeff() - values.minCoeff()); }

nlohmann::ordered_json figures(const ArrayXd& values) {
  const double mean = values.mean(), rms = std::sqrt((values - mean).square().mean());
  return {{"mean", mean}, {"rms", rms}};
}

/// The columns of a table of samples, `names` behind step and time, as rows.
ArrayXXd read_samples(const std::filesystem::path& table, std::size_t names) {
  std::vector<double> numbers;
  std::ifstream file(table);
  std::string row;
  for (std::getline(file, row); std::getline(file, row);)
    for (const char *at = row.data(), *end = at + row.size(); at < end; ++at)
      at = std::from_chars(at, end, numbers.emplace_back()).ptr;
  const auto size = static_cast<Eigen::Index>(2 + names);
  return ArrayXXd::Map(numbers.data(), size, std::ssize(numbers) / size);
}

/// How many samples are of a step from this one on.
Eigen::Index samples_from(const ArrayXXd& samples, std::int64_t step) {
  return (samples.row(0) >= static_cast<double>(step)).count();
}

nlohmann::ordered_json ended_before(std::int64_t step) { return "the run ended before step " + std::to_string(step); }

/// When a signal rises through its mean. Ripples on the way do not count: between two rises it falls below the mean by
/// a tenth of the most that it does.
std::vector<double> rises(const ArrayXd& times, const ArrayXd& signal) {
  const ArrayXd above = signal - signal.mean();
  const double low = 0.1 * above.minCoeff();
  std::vector<double> found;
  bool was_low = false;
  for (Eigen::Index i = 1; i < above.size(); ++i) {
    was_low = was_low || above[i - 1] < low;
    if (!was_low || above[i] < 0.0) continue;
    found.push_back(times[i - 1] + (times[i] - times[i - 1]) * above[i - 1] / (above[i - 1] - above[i]));
    was_low = false;
  }
  return found;
}

/// @param times  in units of L/U
void evaluate(ArrayXd times, ArrayXd drag, ArrayXd lift, nlohmann::ordered_json& report) {
  constexpr double least_oscillation = 5e-4;  // of the drag
  const std::vector<double> found = rises(times, lift);
  const Eigen::Map<const ArrayXd> at(found.data(), std::ssize(found));
  report["strouhal"] = nullptr;
  if (at.size() > 2 && half_span(lift) > least_oscillation * drag.abs().maxCoeff()) {
    const Eigen::Index periods = at.size() - 1, first = (times < at[0]).count();
    const Eigen::Index samples = (times < at[periods]).count() - first;
    drag = drag.segment(first, samples).eval();
    lift = lift.segment(first, samples).eval();
    report["strouhal"] = {{"mean", static_cast<double>(periods) / (at[periods] - at[0])},
                          {"half_span", half_span((at.tail(periods) - at.head(periods)).inverse())},
                          {"periods", periods}};
  }
  report["drag"] = figures(drag);
  report["drag"]["half_span"] = half_span(drag);
  report["lift"] = figures(lift);
  report["lift"]["half_span"] = half_span(lift);
}

}  // namespace

std::vector<std::string> coefficient_columns(const Case& the_case) {
  std::vector<std::string> names;
  for (const Coefficients& each : the_case.output.coefficients)
    for (const char* direction : {".drag", ".lift"}) names.push_back(each.of + direction);
  return names;
}

Eigen::VectorXd coefficients_in(const StepRecord& record, const LoadedCase& loaded) {
  const Case& the_case = loaded.content;
  if (record.step % the_case.output.trajectory_every_steps != 0) return {};
  std::vector<double> values;
  for (const Coefficients& each : the_case.output.coefficients) {
    Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
    Eigen::Index body = 0, obstacle = 0;
    for (const BodySpecification& one : loaded.assembly.bodies)
      if (const auto place = body++; one.name == each.of) force_N = record.applied.force_N.col(place);
    for (const ObstacleSpecification& one : the_case.fluid.obstacles)
      if (const auto place = one.loads ? obstacle++ : -1; place >= 0 && one.name == each.of)
        force_N = record.obstacles.force_N.col(place);
    const double unit_N = 0.5 * the_case.fluid.density_kg_per_m3 * std::pow(each.speed_m_per_s, 2) * each.area_m2;
    for (const Eigen::Vector3d& axis : {each.drag_axis, each.lift_axis}) values.push_back(axis.dot(force_N) / unit_N);
  }
  return Eigen::VectorXd::Map(values.data(), std::ssize(values));
}

nlohmann::ordered_json coefficient_report(const std::filesystem::path& table, const Case& the_case) {
  auto all = nlohmann::ordered_json::array();
  const ArrayXXd samples = read_samples(table, 2 * the_case.output.coefficients.size());
  Eigen::Index line = 2;
  for (const Coefficients& each : the_case.output.coefficients) {
    const Eigen::Index count = samples_from(samples, each.from_step);
    const auto values = [&](Eigen::Index quantity) { return samples.row(quantity).tail(count).transpose(); };
    nlohmann::ordered_json& report = all.emplace_back(nlohmann::ordered_json{{"name", each.of}});
    if (count > 0)
      evaluate(values(1) * each.speed_m_per_s / each.length_m, values(line), values(line + 1), report);
    else
      report["note"] = ended_before(each.from_step);
    line += 2;
  }
  return all;
}

nlohmann::ordered_json flow_report(const std::filesystem::path& table, const std::vector<std::string>& names,
                                   std::int64_t from_step) {
  auto all = nlohmann::ordered_json::array();
  const ArrayXXd samples = read_samples(table, names.size());
  const Eigen::Index count = samples_from(samples, from_step);
  Eigen::Index line = 2;
  for (const std::string& name : names) {
    nlohmann::ordered_json& report = all.emplace_back(nlohmann::ordered_json{{"name", name}});
    const ArrayXd values = samples.row(line++).tail(count).transpose();
    if (count == 0) {
      report["note"] = ended_before(from_step);
      continue;
    }
    report.update(figures(values));
    report["min"] = values.minCoeff();
    report["max"] = values.maxCoeff();
  }
  return all;
}

}  // namespace copepod::coupler
