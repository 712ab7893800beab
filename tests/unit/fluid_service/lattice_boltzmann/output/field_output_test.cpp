#include "lattice_boltzmann/output/field_output.hpp"

#include <sstream>

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "temporary_folder.hpp"

namespace copepod::fluid {
namespace {

/// A cell whose density is the step, so that the sum shows which steps entered.
FieldBlock cell_at(std::int64_t step) { return {{{0, 0, 0}, {1, 1, 1}}, {static_cast<double>(step)}, {0, 0, 0}, {0}}; }

/// A run of a fluid that is nothing but its mean field.
class MeanRun {
 public:
  MeanRun(std::int64_t mean_start, std::int64_t mean_stop, std::int64_t mean_every_steps) {
    setup_.domain_cells = {1, 1, 1};
    setup_.fields = {folder_.path().string(), 0, mean_start, mean_stop, mean_every_steps, {}, {}, 0};
    schedule_ = std::make_unique<FieldSchedule>(setup_, self_);
  }
  MeanRun(std::int64_t mean_start, std::int64_t mean_stop, std::int64_t mean_every_steps, std::int64_t step)
      : MeanRun(mean_start, mean_stop, mean_every_steps) {
    advance_to(step);
  }

  void advance_to(std::int64_t step) {
    while (step_ < step) {
      if (step_ == 0) schedule_->after_step(0, [] { return cell_at(0); });
      ++step_;
      schedule_->after_step(step_, [this] { return cell_at(step_); });
    }
  }

  /// Continues from the checkpoint that another run has just written.
  /// @return the log of it
  std::string resume(const MeanRun& other) {
    std::ostringstream text;
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_st>(text)));
    step_ = other.step_;
    schedule_->restore(step_, other.schedule_->sampling(), other.schedule_->mean());
    spdlog::set_default_logger(before);
    return text.str();
  }

  [[nodiscard]] std::int64_t samples() const { return schedule_->mean().samples(); }
  [[nodiscard]] double sum() const { return samples() == 0 ? 0.0 : schedule_->mean().sums().density_kg_per_m3[0]; }

 private:
  TemporaryFolder folder_;
  SolverContext context_;
  SelfCommunicator self_{context_};
  FluidSetup setup_;
  std::unique_ptr<FieldSchedule> schedule_;
  std::int64_t step_ = 0;
};

TEST(FieldSchedule, SamplesItsWindow) {
  const MeanRun run(10, 21, 5, 25);
  EXPECT_EQ(run.samples(), 3);
  EXPECT_EQ(run.sum(), 10 + 15 + 20);
  EXPECT_EQ(MeanRun(0, 30, 1, 30).samples(), 30);
  EXPECT_EQ(MeanRun(0, 10, 10, 10).samples(), 1);
}

TEST(FieldSchedule, GoesOnWithTheSumsOfTheSameWindow) {
  for (const std::int64_t start : {0, 1, 7, 10})
    for (const std::int64_t every : {1, 3, 10})
      for (const std::int64_t checkpoint : {0, 1, 6, 7, 9, 10, 11, 20, 30, 35}) {
        const MeanRun undisturbed(start, 30, every, 40);
        MeanRun resumed(start, 30, every);
        EXPECT_EQ(resumed.resume(MeanRun(start, 30, every, checkpoint)), "");
        resumed.advance_to(40);
        EXPECT_EQ(resumed.samples(), undisturbed.samples()) << start << ' ' << every << ' ' << checkpoint;
        EXPECT_EQ(resumed.sum(), undisturbed.sum());
      }
}

TEST(FieldSchedule, GoesOnInAWindowThatWasMadeLongerInTime) {
  MeanRun resumed(10, 30, 1);
  EXPECT_EQ(resumed.resume(MeanRun(10, 20, 1, 15)), "");
  resumed.advance_to(40);
  EXPECT_EQ(resumed.samples(), 20);
}

TEST(FieldSchedule, LeavesOutTheSumsOfOtherStepsAndSaysSo) {
  struct Window {
    std::int64_t start, stop, every;
  };
  for (const auto& [start, stop, every] :
       {Window{5, 100, 1}, Window{1, 100, 1}, Window{0, 100, 2}, Window{0, 15, 1}, Window{40, 90, 1}}) {
    MeanRun resumed(start, stop, every);
    const std::string log = resumed.resume(MeanRun(0, 100, 1, 20));
    EXPECT_NE(log.find("The 21 samples of the checkpoint"), std::string::npos) << log;
    EXPECT_EQ(log.find("will lack") == std::string::npos, start == 40) << log;
    EXPECT_EQ(resumed.samples(), 0) << start << ' ' << stop << ' ' << every;
  }
}

TEST(FieldSchedule, LeavesOutSumsOfAWindowThatWasMadeLongerTooLate) {
  MeanRun resumed(0, 40, 1);
  EXPECT_NE(resumed.resume(MeanRun(0, 20, 1, 25)).find("will lack 26 samples"), std::string::npos);
  resumed.advance_to(26);
  EXPECT_EQ(resumed.sum(), 26);
}

TEST(FieldSchedule, SaysWhatAMeanLacksThatTheRunBeforeDidNotWant) {
  MeanRun resumed(10, 100, 1);
  EXPECT_NE(resumed.resume(MeanRun(0, 0, 1, 20)).find("will lack 11 samples"), std::string::npos);
}

}  // namespace
}  // namespace copepod::fluid
