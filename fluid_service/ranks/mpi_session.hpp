#pragma once

#include <memory>

#include "ranks/communicator.hpp"

namespace copepod::fluid {

class MpiCommunicator;

/// MPI from initialisation to the end of the process; one object per process.
///
/// A rank started by mpirun ends with it, even if mpirun is killed.
class MpiSession {
 public:
  MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
  /// Ends MPI; after a failure, when a collective end could wait for ever, aborts all ranks with
  /// `exit_code()`.
  ~MpiSession();

  [[nodiscard]] Communicator& ranks();

  /// Exit code with which a failed session aborts. @return `code`, so that main can `return
  /// session.finish(…)`.
  int finish(int code);
  [[nodiscard]] int exit_code() const { return exit_code_; }

 private:
  SolverContext context_;
  std::unique_ptr<MpiCommunicator> communicator_;
  int exit_code_;
};

}  // namespace copepod::fluid
