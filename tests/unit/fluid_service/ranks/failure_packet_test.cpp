#include "ranks/failure_packet.hpp"

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

TEST(FailurePacket, KeepsAReport) {
  const FailureReport sent{ExitCode::storage_failed,         "fluid", "node7", 12, 3456,
                           "disk full (no room). Make room."};
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
