#include <cstdlib>

#include <gtest/gtest.h>

#include "ranks/mpi_communicator.hpp"
#include "ranks/thread_ranks.hpp"
#include "test_on_ranks.hpp"

namespace {

int threads = 0;  ///< 0: the ranks are processes of mpirun

}  // namespace

void copepod::fluid::run_on_ranks(const std::function<void(Communicator&)>& body) {
  SolverContext context;
  if (threads == 0) {
    MpiCommunicator ranks{context};
    body(ranks);
  } else {
    ThreadRanks ranks(threads, context, body);
    body(ranks.leader());
  }
}

/// [THREADS]: on so many threads; else under mpirun.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    threads = std::atoi(argv[1]);
    return RUN_ALL_TESTS();
  }
  copepod::fluid::MpiSession session;
  return session.finish(RUN_ALL_TESTS());
}
