#include <gtest/gtest.h>

#include "ranks/mpi_communicator.hpp"

namespace copepod::fluid {
namespace {

TEST(Backoff, YieldsAtFirst) {
  EXPECT_EQ(Backoff::pause_s(0.0), 0.0);
  EXPECT_EQ(Backoff::pause_s(99e-6), 0.0);
}

TEST(Backoff, AddsAnEighthToAWaitAndAMillisecondAtMost) {
  EXPECT_DOUBLE_EQ(Backoff::pause_s(200e-6), 25e-6);
  EXPECT_DOUBLE_EQ(Backoff::pause_s(4e-3), 0.5e-3);
  EXPECT_EQ(Backoff::pause_s(3600.0), 1e-3);
}

}  // namespace
}  // namespace copepod::fluid
