#pragma once

#include <functional>

#include <gtest/gtest.h>

#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Runs `body` on every rank: under mpirun this process is one; without it each rank is a thread, and their number is
/// the program's argument.
void run_on_ranks(const std::function<void(Communicator&)>& body);

}  // namespace copepod::fluid

/// TEST whose body runs on every rank, with `ranks`, its Communicator.
#define TEST_ON_RANKS(suite, name)                    \
  void suite##_##name(Communicator& ranks);           \
  TEST(suite, name) { run_on_ranks(suite##_##name); } \
  void suite##_##name(Communicator& ranks)

/// TEST_P likewise, with `parameter` too.
#define TEST_P_ON_RANKS(suite, name)                                               \
  void suite##_##name(const suite::ParamType& parameter, Communicator& ranks);     \
  TEST_P(suite, name) {                                                            \
    run_on_ranks([&](Communicator& ranks) { suite##_##name(GetParam(), ranks); }); \
  }                                                                                \
  void suite##_##name(const suite::ParamType& parameter, Communicator& ranks)
