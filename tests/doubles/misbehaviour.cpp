#include "misbehaviour.hpp"

#include <chrono>
#include <thread>

#include "contract/errors.hpp"

namespace copepod::doubles {

namespace {

void sleep_for_slices(const Misbehaviour& how, SolverContext& context) {
  for (int slept = 0; slept < how.slow_ms; slept += 10) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (how.reports_progress) context.report_progress();
  }
}

void misbehave(const Misbehaviour& how, std::int64_t step) {
  while (step == how.hang_at_step) std::this_thread::sleep_for(std::chrono::seconds(1));
  if (step == how.throw_at_step) {
    throw SolverError("The flow diverged (as this test asked for). Ask for something else.", 3, step);
  }
}

class MisbehavingFluid final : public FluidSolver {
 public:
  MisbehavingFluid(std::unique_ptr<FluidSolver> inner, const Misbehaviour& how, SolverContext& context)
      : inner_(std::move(inner)), how_(how), context_(context) {}

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    step_ = kinematics.step;
    misbehave(how_, step_);
    inner_->exchange(kinematics, loads);
  }

  void advance() override {
    sleep_for_slices(how_, context_);
    if (step_ == how_.throw_in_advance_of_step) {
      throw SolverError("The bulk update diverged (as this test asked for). Ask for something else.", 1, step_);
    }
    inner_->advance();
  }

  void save(const std::string& path) override { inner_->save(path); }
  void restore(const std::string& path) override { inner_->restore(path); }
  SolverSummary summarise() override { return inner_->summarise(); }

 private:
  std::unique_ptr<FluidSolver> inner_;
  Misbehaviour how_;
  SolverContext& context_;
  std::int64_t step_ = -1;
};

class MisbehavingBody final : public BodySolver {
 public:
  MisbehavingBody(std::unique_ptr<BodySolver> inner, const Misbehaviour& how, SolverContext& context)
      : inner_(std::move(inner)), how_(how), context_(context) {}

  [[nodiscard]] std::vector<double> driving_nodes() const override { return inner_->driving_nodes(); }
  void kinematics(Kinematics& kinematics) override { inner_->kinematics(kinematics); }
  void step(const AppliedLoads& applied, Kinematics& next) override {
    misbehave(how_, applied.hydrodynamic.step);
    sleep_for_slices(how_, context_);
    inner_->step(applied, next);
  }

  void save(const std::string& path) override { inner_->save(path); }
  void restore(const std::string& path) override { inner_->restore(path); }
  SolverSummary summarise() override { return inner_->summarise(); }

 private:
  std::unique_ptr<BodySolver> inner_;
  Misbehaviour how_;
  SolverContext& context_;
};

}  // namespace

FluidComponent misbehaving(const FluidComponent& component, const Misbehaviour& how) {
  return {component.capabilities, [component, how](const FluidSetup& setup, SolverContext& context) {
            return std::make_unique<MisbehavingFluid>(component.make_solver(setup, context), how, context);
          }};
}

BodyComponent misbehaving(const BodyComponent& component, const Misbehaviour& how) {
  return {component.capabilities, [component, how](const BodySetup& setup, SolverContext& context) {
            return std::make_unique<MisbehavingBody>(component.make_solver(setup, context), how, context);
          }};
}

}  // namespace copepod::doubles
