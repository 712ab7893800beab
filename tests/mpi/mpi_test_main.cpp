#include <gtest/gtest.h>

#include "ranks/mpi_session.hpp"

int main(int argc, char** argv) {
  copepod::fluid::MpiSession session;
  testing::InitGoogleTest(&argc, argv);
  return session.finish(RUN_ALL_TESTS());
}
