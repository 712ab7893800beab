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

TEST(FailurePacket, KeepsAReport) {
  const FailureReport sent{ExitCode::storage_failed, "fluid", "node7", 12, 3456, "disk full (no room). Make room."};
  const FailureReport got = unpack_failure(pack_failure(sent));
  EXPECT_EQ(got.code, sent.code);
  EXPECT_EQ(got.component, sent.component);
  EXPECT_EQ(got.host, sent.host);
  EXPECT_EQ(got.rank, 12);
  EXPECT_EQ(got.step, 3456);
  EXPECT_EQ(got.reason, sent.reason);
}

TEST(FailurePacket, CutsALongReasonBetweenTwoCharacters) {
  FailureReport sent;
  sent.reason = "x";
  while (sent.reason.size() < 5000) sent.reason += "×";  // two bytes each: an even limit falls inside one
  const FailureReport got = unpack_failure(pack_failure(sent));
  EXPECT_EQ(got.reason.size(), 1599U);
  EXPECT_EQ(got.reason.substr(got.reason.size() - 2), "×");
}

}  // namespace
}  // namespace copepod::fluid
