#include "fake_arguments.hpp"

#include <CLI/CLI.hpp>

#include "component/run_component.hpp"

namespace copepod::doubles {

FakeArguments::FakeArguments(int argc, char** argv) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  app.add_option("--hang-at-step", misbehaviour_.hang_at_step);
  app.add_option("--throw-at-step", misbehaviour_.throw_at_step);
  app.add_option("--throw-in-advance-of-step", misbehaviour_.throw_in_advance_of_step);
  app.add_option("--slow-ms", misbehaviour_.slow_ms);
  app.add_flag("--reports-progress", misbehaviour_.reports_progress);
  app.add_option("--halt-in", halt_.in);
  app.add_option("--halt-at-step", halt_.at_step);
  app.add_option("--halt-rank", halt_.rank);
  app.add_option("--halt-file", halt_.file);
  app.add_flag("--hang", halt_.hangs);
  app.parse(argc, argv);
  texts_ = app.remaining();
  texts_.insert(texts_.begin(), argv[0]);
  for (std::string& text : texts_) pointers_.push_back(text.data());
  pointers_.push_back(nullptr);
  if (!starts_service(this->argc(), this->argv())) halt_.in.clear();  // only a question
}

}  // namespace copepod::doubles
