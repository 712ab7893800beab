#include "ranks/rank_failure.hpp"

#include <new>
#include <stdexcept>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

TEST(RankFailure, TakesCodeAndStepFromOurOwnErrors) {
  const FailureReport report = failure_of_rank(SolverError("diverged", 0, 41), 3, 40);
  EXPECT_EQ(report.code, ExitCode::solver_failed);
  EXPECT_EQ(report.component, "fluid");
  EXPECT_EQ(report.rank, 3);
  EXPECT_EQ(report.step, 41);
  EXPECT_EQ(report.reason, "diverged");
  EXPECT_FALSE(report.host.empty());
}

TEST(RankFailure, NamesTheStepOfTheLastExchangeWhereTheErrorDoesNotKnowIt) {
  EXPECT_EQ(failure_of_rank(StorageError("disk full"), 1, 40).step, 40);
  EXPECT_EQ(failure_of_rank(StorageError("disk full"), 1, 40).code, ExitCode::storage_failed);
  EXPECT_EQ(failure_of_rank(std::runtime_error("odd"), 1, 40).reason, "odd");
}

TEST(RankFailure, ExplainsWhatToDoWhenMemoryRunsOut) {
  EXPECT_NE(failure_of_rank(std::bad_alloc(), 1, -1).reason.find("out of memory"), std::string::npos);
}

}  // namespace
}  // namespace copepod::fluid
