#include "halt.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>

namespace copepod::doubles {

namespace {

[[noreturn]] void hang() {
  volatile bool forever = true;
  while (forever) {
  }
  std::abort();
}

/// What fluids and bodies do alike.
template <class Solver>
class Halting : public Solver {
 public:
  Halting(std::unique_ptr<Solver> inner, Halt halt, SolverContext& context)
      : inner_(std::move(inner)), halt_(std::move(halt)), context_(context) {}

  void save(const std::string& path) override {
    halt_here(halt_, "save", step_, &context_);
    inner_->save(path);
  }
  void restore(const std::string& path) override { inner_->restore(path); }
  SolverSummary summarise() override {
    halt_here(halt_, "summarise", 0, &context_);
    return inner_->summarise();
  }

 protected:
  std::unique_ptr<Solver> inner_;
  Halt halt_;
  SolverContext& context_;
  std::int64_t step_ = 0;
};

class HaltingFluid final : public Halting<FluidSolver> {
 public:
  using Halting::Halting;

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    step_ = kinematics.step;
    halt_here(halt_, "exchange", step_, &context_);
    inner_->exchange(kinematics, loads);
  }
  void advance() override {
    halt_here(halt_, "advance", step_, &context_);
    inner_->advance();
  }
};

class HaltingBody final : public Halting<BodySolver> {
 public:
  using Halting::Halting;

  [[nodiscard]] std::vector<double> driving_nodes() const override { return inner_->driving_nodes(); }
  void kinematics(Kinematics& kinematics) override { inner_->kinematics(kinematics); }
  void step(const AppliedLoads& applied, Kinematics& next) override {
    step_ = applied.hydrodynamic.step;
    halt_here(halt_, "exchange", step_, &context_);
    inner_->step(applied, next);
  }
};

}  // namespace

void halt_here(const Halt& halt, const std::string& place, std::int64_t step, SolverContext* context) {
  static bool has_halted = false;
  if (has_halted || place != halt.in || step < halt.at_step) return;
  has_halted = true;
  std::ofstream(halt.file).close();
  if (halt.hangs) hang();
  while (std::filesystem::exists(halt.file)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (context != nullptr) context->report_progress();
  }
}

std::unique_ptr<FluidSolver> halting(std::unique_ptr<FluidSolver> solver, const Halt& halt, int rank,
                                     SolverContext& context) {
  if (rank != halt.rank) return solver;
  return std::make_unique<HaltingFluid>(std::move(solver), halt, context);
}

std::unique_ptr<BodySolver> halting(std::unique_ptr<BodySolver> solver, const Halt& halt, SolverContext& context) {
  return std::make_unique<HaltingBody>(std::move(solver), halt, context);
}

}  // namespace copepod::doubles
