#include "ranks/mpi_session.hpp"

#include <csignal>
#include <cstdlib>
#include <sys/prctl.h>
#include <unistd.h>

#include <mpi.h>

#include "contract/exit_code.hpp"
#include "ranks/mpi_communicator.hpp"

namespace copepod::fluid {

namespace {

constexpr unsigned rank_0_reports_s = 10;  ///< time for rank 0 to report a failure to the coupler
constexpr unsigned last_resort_s = 15;     ///< a rank that hangs must not keep the others from ending for longer

/// Dies with mpirun: it starts the ranks of its machine itself, and kill -9 leaves it no time to stop them.
void die_with_parent() {
  if (std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
}

/// Sleeps of the polled waits last as long as asked for, not up to 50 µs longer.
void sleep_exactly() { prctl(PR_SET_TIMERSLACK, 1000UL); }

}  // namespace

MpiSession::MpiSession() : exit_code_(static_cast<int>(ExitCode::solver_failed)) {
  die_with_parent();
  sleep_exactly();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a full disk, not the end
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED,
                  &provided);  // errors end the process by MPI's default
  communicator_ = std::make_unique<MpiCommunicator>(context_);
}

MpiSession::~MpiSession() {
  alarm(last_resort_s);
  if (communicator_->broken()) {
    // Rank 0 has reported the cause to the coupler before this point; the others leave it the time to do so.
    if (communicator_->rank() != 0) sleep(rank_0_reports_s);
    MPI_Abort(MPI_COMM_WORLD, exit_code_);
  }
  communicator_.reset();
  MPI_Finalize();
  alarm(0);
}

Communicator& MpiSession::ranks() { return *communicator_; }

int MpiSession::finish(int code) {
  exit_code_ = code;
  return code;
}

}  // namespace copepod::fluid
