#include "config/load_case.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "config/checks/checks.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"

namespace copepod::coupler {
namespace {

/// Text for few bodies, HDF5 for many [docs/decisions/trajectories.md].
void settle_trajectory(std::size_t bodies, OutputCase& output) {
  constexpr std::size_t few = 100;
  if (output.trajectory_format == TrajectoryFormat::by_bodies)
    output.trajectory_format = bodies > few ? TrajectoryFormat::hdf5 : TrajectoryFormat::csv;
}

/// The form of older versions.
void refuse_forces(const Document& document) {
  const Value* forces = document.root().find("forces");
  const bool empty = forces != nullptr && forces->kind == Value::Kind::sequence && forces->items.empty();
  if (forces == nullptr || empty) return;
  throw CaseInvalid(document.locate("forces"),
                    "forces has become actuators (they can follow a body or an arm). Write actuators: [{kind: "
                    "world_force, body: a, direction: [0, 0, 1], signal: {kind: constant, amplitude_N: 1.0e-9}}], or "
                    "signal: {kind: sinusoid, amplitude_N: …, period_steps: …, lag_steps: …}.");
}

void refuse_campaign(const Document& document) {
  if (document.root().find("campaign") == nullptr) return;
  throw CaseInvalid(document.locate("campaign"),
                    "the file is a campaign (a list of cases). Run it with `copepod campaign`, or name one of its "
                    "cases.");
}

LoadedCase read_one(const Document& document) {
  refuse_forces(document);
  Problems problems(document, case_keys);
  LoadedCase loaded;
  loaded.content = read_case(Reader(&document.root(), "", problems));
  loaded.assembly = assemble(loaded.content);
  settle_trajectory(loaded.assembly.bodies.size(), loaded.content.output);
  check_case(loaded.content, loaded.assembly, problems);
  problems.throw_if_any();
  loaded.warnings = problems.warnings();
  return loaded;
}

/// Lines of several members of a sweep, each with the members that have it.
class LinesOfMembers {
 public:
  void add(const std::string& line, const std::string& member) {
    const auto found = std::ranges::find(lines_, line, &Line::text);
    if (found != lines_.end())
      ++found->members;
    else
      lines_.push_back({line, member, 1});
  }

  [[nodiscard]] bool empty() const { return lines_.empty(); }

  /// With the first of the members, unless all of them have the line.
  [[nodiscard]] std::vector<std::string> texts(std::size_t members) const {
    constexpr std::size_t most = 20;
    std::vector<std::string> result;
    for (const Line& line : std::span(lines_).first(std::min(most, lines_.size()))) {
      const std::string others =
          line.members == 1 ? ""
                            : " and " + std::to_string(line.members - 1) + (line.members == 2 ? " other" : " others");
      result.push_back(line.members == members ? line.text
                                               : line.text + " [in member " + line.first_member + others + "]");
    }
    if (lines_.size() > most) result.push_back("… and " + std::to_string(lines_.size() - most) + " more like these.");
    return result;
  }

 private:
  struct Line {
    std::string text;
    std::string first_member;
    std::size_t members;
  };
  std::vector<Line> lines_;
};

/// Checks every member of a sweep, so that none fails after hours.
LoadedCase read_members(const Document& document, const Sweep& sweep) {
  LinesOfMembers errors, warnings;
  std::optional<LoadedCase> first;
  const std::size_t members = member_count(sweep);
  for (std::size_t member = 0; member < members; ++member) {
    try {
      LoadedCase loaded = read_one(document.with(assignments_of(sweep, member)));
      for (const std::string& line : loaded.warnings) warnings.add(line, member_text(sweep, member));
      if (!first) first = std::move(loaded);
    } catch (const CaseInvalid& invalid) {
      for (const std::string& line : invalid.lines()) errors.add(line, member_text(sweep, member));
    }
  }
  if (!errors.empty()) throw CaseInvalid(errors.texts(members));
  first->warnings = warnings.texts(members);
  first->sweep = sweep;
  return std::move(*first);
}

LoadedCase read_document(const Document& document) {
  refuse_campaign(document);
  const std::optional<Sweep> sweep = read_sweep(document);
  return sweep ? read_members(document, *sweep) : read_one(document);
}

}  // namespace

LoadedCase load_case(const std::string& file, const std::vector<std::string>& overrides) {
  return read_document(Document::load(file, overrides));
}

LoadedCase load_case_text(const std::string& text, const std::string& source,
                          const std::vector<std::string>& overrides) {
  return read_document(Document::parse(text, source, overrides));
}

}  // namespace copepod::coupler
