#include "config/load_case.hpp"

#include "config/checks/checks.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"

namespace copepod::coupler {
namespace {

double derived_step_s(const Case& the_case) {
  if (the_case.given_step_s) return *the_case.given_step_s;
  const FluidCase& fluid = the_case.fluid;
  if (!fluid.relaxation_time || fluid.cell_size_m <= 0.0 || fluid.kinematic_viscosity_m2_per_s <= 0.0)
    return 0.0;
  return step_from_relaxation_time(*fluid.relaxation_time, fluid.cell_size_m,
                                   fluid.kinematic_viscosity_m2_per_s);
}

void refuse_campaign(const Document& document) {
  if (document.root().find("campaign") == nullptr) return;
  throw CaseInvalid(
      document.locate("campaign"),
      "the file is a campaign (a list of cases). Run it with `copepod campaign`, or name one of its "
      "cases.");
}

LoadedCase read_document(const Document& document, AskedKeys* asked) {
  refuse_campaign(document);
  Problems problems(document);
  LoadedCase loaded;
  loaded.content = read_case(Reader(&document.root(), "", problems, asked));
  loaded.content.step_s = derived_step_s(loaded.content);
  loaded.assembly = assemble(loaded.content);
  check_case(loaded.content, loaded.assembly, problems);
  problems.throw_if_any();
  loaded.warnings = problems.warnings();
  return loaded;
}

}  // namespace

LoadedCase load_case(const std::string& file, const std::vector<std::string>& overrides) {
  return read_document(Document::load(file, overrides), nullptr);
}

LoadedCase load_case_text(const std::string& text, const std::string& source,
                          const std::vector<std::string>& overrides, AskedKeys* asked) {
  return read_document(Document::parse(text, source, overrides), asked);
}

}  // namespace copepod::coupler
