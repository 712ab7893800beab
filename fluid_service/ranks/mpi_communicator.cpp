#include "ranks/mpi_communicator.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <sys/prctl.h>
#include <unistd.h>
#include <utility>

#include "contract/errors.hpp"
#include "ranks/communicator.hpp"
#include "ranks/rank_failure.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

namespace {

constexpr int failure_tag = 1;
constexpr int exchange_tag = 2;
constexpr int send_tag = 3;
/// Numbers in one reduction. From 64 KiB on Open MPI 4.1 sends them down a chain in many small pieces, each
/// of which waits for all ranks: 5.4 ms in place of 0.2 for the loads of 1000 bodies.
constexpr std::size_t largest_reduction = 6000;
constexpr double look_every_s = 0.1;  ///< of a long wait: at the other ranks
constexpr double farewell_s = 0.2;    ///< how long a failing rank tries to get its report out

void check(int status, const char* call) {
  if (status == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = {};
  int length = 0;
  MPI_Error_string(status, text, &length);
  throw ComponentLost(std::string(call) + " failed (" + text + "). See the logs of the other ranks; resume the run.");
}

int count_of(std::size_t size) {
  if (size > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw CaseError("a message of " + std::to_string(size) +
                    " bytes between two ranks (MPI counts to 2^31). Use more ranks.");
  return static_cast<int>(size);
}

MPI_Comm duplicate_of_world() {
  MPI_Comm duplicate = MPI_COMM_NULL;
  check(MPI_Comm_dup(MPI_COMM_WORLD, &duplicate), "MPI_Comm_dup");
  check(MPI_Comm_set_errhandler(duplicate, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  return duplicate;
}

constexpr unsigned rank_0_reports_s = 10;  ///< time for rank 0 to report a failure to the coupler
constexpr unsigned last_resort_s = 15;     ///< a rank that hangs must not keep the others from ending for longer

}  // namespace

MpiCommunicator::MpiCommunicator(SolverContext& context)
    : Communicator(context), ranks_(duplicate_of_world()), failures_(duplicate_of_world()) {
  check(MPI_Comm_rank(ranks_, &rank_), "MPI_Comm_rank");
  check(MPI_Comm_size(ranks_, &size_), "MPI_Comm_size");
  if (size_ > 1) heartbeats_ = std::make_unique<HeartbeatBoard>(ranks_, context);
}

MpiCommunicator::~MpiCommunicator() {
  if (broken()) return;
  if (heartbeats_) heartbeats_->free();
  MPI_Comm_free(&failures_);
  MPI_Comm_free(&ranks_);
}

void MpiCommunicator::look_for_failure() {
  if (size_ == 1) return;
  int arrived = 0;
  MPI_Status status;
  check(MPI_Iprobe(MPI_ANY_SOURCE, failure_tag, failures_, &arrived, &status), "MPI_Iprobe");
  if (arrived == 0) return;
  FailurePacket packet;
  check(MPI_Recv(&packet, sizeof(packet), MPI_BYTE, status.MPI_SOURCE, failure_tag, failures_, MPI_STATUS_IGNORE),
        "MPI_Recv");
  failure_ = unpack_failure(packet);
  throw_if_failed();
}

void MpiCommunicator::look_at_ranks() {
  if (!heartbeats_) return;
  heartbeats_->show_waiting(true);
  if (rank_ != 0) return;
  const RankVerdict verdict = watch_.look(heartbeats_->read(), now_s());
  if (verdict.progressed) context().report_progress();
  context().await_rank(verdict.awaited);
  if (!verdict.frozen) return;
  failure_ = failure_of_rank(ComponentLost("frozen: it has shown no sign of life for some seconds (its process is "
                                           "suspended). See what suspended it, then resume the run."),
                             *verdict.frozen, -1);
  throw_if_failed();
}

void MpiCommunicator::stop_waiting() {
  if (!heartbeats_) return;
  heartbeats_->show_waiting(false);
  context().await_rank(0);
}

void MpiCommunicator::wait(MPI_Request& request) {
  wait_until([&] {
    int complete = 0;
    check(MPI_Test(&request, &complete, MPI_STATUS_IGNORE), "MPI_Test");
    return complete != 0;
  });
}

template <class Poll>
void MpiCommunicator::wait_until(const Poll& poll) {
  const Backoff backoff;
  double next_look_s = look_every_s;
  while (true) {
    if (poll()) {
      if (next_look_s > look_every_s) stop_waiting();
      return;
    }
    if (backoff.waited_s() > next_look_s) {
      look_at_ranks();
      next_look_s = backoff.waited_s() + look_every_s;
    }
    look_for_failure();
    if (const int code = context().stop_requested(); code != 0)
      throw Error(static_cast<ExitCode>(code),
                  "stopped while waiting for another rank (the coupler ended the run). See the coupler's log.");
    backoff.pause();
  }
}

/// A collective that is given up cannot be taken back: MPI may still write to its buffer, which then stays.
template <class Start>
void MpiCommunicator::collective(std::span<std::byte> data, const char* call, const Start& start) {
  auto buffer = std::make_unique<std::vector<std::byte>>(data.begin(), data.end());
  MPI_Request request = MPI_REQUEST_NULL;
  check(start(buffer->data(), &request), call);
  try {
    wait(request);
  } catch (...) {
    static_cast<void>(buffer.release());
    throw;
  }
  std::ranges::copy(*buffer, data.begin());
}

void MpiCommunicator::broadcast(std::span<std::byte> data) {
  throw_if_failed();
  if (size_ == 1) return;
  collective(data, "MPI_Ibcast", [&](std::byte* buffer, MPI_Request* request) {
    return MPI_Ibcast(buffer, count_of(data.size()), MPI_BYTE, 0, ranks_, request);
  });
}

void MpiCommunicator::reduce_to_leader(std::span<std::int64_t> values, Reduction reduction) {
  throw_if_failed();
  if (size_ == 1) return;
  // Unsigned sums: the same bits as signed ones, and defined where digests wrap around.
  const MPI_Datatype type = reduction == Reduction::sum ? MPI_UINT64_T : MPI_INT64_T;
  const MPI_Op operation = reduction == Reduction::sum ? MPI_SUM : MPI_MAX;
  for (; !values.empty(); values = values.subspan(std::min(values.size(), largest_reduction))) {
    const auto piece = values.first(std::min(values.size(), largest_reduction));
    collective(std::as_writable_bytes(piece), "MPI_Ireduce", [&](std::byte* buffer, MPI_Request* request) {
      const void* send = rank_ == 0 ? MPI_IN_PLACE : buffer;
      return MPI_Ireduce(send, buffer, count_of(piece.size()), type, operation, 0, ranks_, request);
    });
  }
}

/// Sends and receives under way; gives them up when it is destroyed unfinished, so that MPI never writes into
/// buffers that the failing solver has freed.
class MpiCommunicator::PendingExchange {
 public:
  explicit PendingExchange(MpiCommunicator& communicator) : communicator_(communicator) {}
  PendingExchange(const PendingExchange&) = delete;
  PendingExchange& operator=(const PendingExchange&) = delete;
  ~PendingExchange() {
    for (MPI_Request& request : receives_) {
      if (request == MPI_REQUEST_NULL) continue;
      MPI_Cancel(&request);
      MPI_Request_free(&request);
    }
    for (MPI_Request& request : sends_)
      if (request != MPI_REQUEST_NULL) MPI_Request_free(&request);
  }

  void receive(int peer, std::span<std::byte> data) {
    check(MPI_Irecv(data.data(), count_of(data.size()), MPI_BYTE, peer, exchange_tag, communicator_.ranks_,
                    &receives_.emplace_back(MPI_REQUEST_NULL)),
          "MPI_Irecv");
  }
  void send(int peer, int tag, std::span<const std::byte> data) {
    check(MPI_Isend(data.data(), count_of(data.size()), MPI_BYTE, peer, tag, communicator_.ranks_,
                    &sends_.emplace_back(MPI_REQUEST_NULL)),
          "MPI_Isend");
  }
  void finish() {
    communicator_.throw_if_failed();
    for (MPI_Request& request : receives_) communicator_.wait(request);
    for (MPI_Request& request : sends_) communicator_.wait(request);
  }

 private:
  MpiCommunicator& communicator_;
  std::vector<MPI_Request> receives_;
  std::vector<MPI_Request> sends_;
};

std::function<void()> MpiCommunicator::start_exchange(std::span<const Message> messages) {
  throw_if_failed();
  // std::function requires a copyable target, hence shared ownership despite a single owner.
  const auto pending = std::make_shared<PendingExchange>(*this);
  for (const Message& message : messages) pending->receive(message.peer, message.receive);
  for (const Message& message : messages) pending->send(message.peer, exchange_tag, message.send);
  return [pending] { pending->finish(); };
}

std::function<void()> MpiCommunicator::start_send(int peer, std::span<const std::byte> data) {
  throw_if_failed();
  const auto pending = std::make_shared<PendingExchange>(*this);
  pending->send(peer, send_tag, data);
  return [pending] { pending->finish(); };
}

void MpiCommunicator::receive(int peer, std::vector<std::byte>& data) {
  throw_if_failed();
  MPI_Message message = MPI_MESSAGE_NULL;
  MPI_Status status;
  wait_until([&] {
    int arrived = 0;
    check(MPI_Improbe(peer, send_tag, ranks_, &arrived, &message, &status), "MPI_Improbe");
    return arrived != 0;
  });
  int size = 0;
  check(MPI_Get_count(&status, MPI_BYTE, &size), "MPI_Get_count");
  data.resize(size);
  MPI_Request request = MPI_REQUEST_NULL;
  check(MPI_Imrecv(data.data(), size, MPI_BYTE, &message, &request), "MPI_Imrecv");
  try {
    wait(request);
  } catch (...) {
    static_cast<void>(std::make_unique<std::vector<std::byte>>(std::move(data)).release());  // as of a collective
    throw;
  }
}

void MpiCommunicator::report_failure(const FailureReport& report) {
  if (failure_) return;  // all ranks have the first report already, or will get it from that rank
  failure_ = report;
  if (size_ == 1) return;
  static FailurePacket packet;  // outlives the sends, whatever becomes of this object
  packet = pack_failure(report);
  std::vector<MPI_Request> requests(size_, MPI_REQUEST_NULL);
  for (int peer = 0; peer < size_; ++peer) {
    if (peer == rank_) continue;
    MPI_Isend(&packet, sizeof(packet), MPI_BYTE, peer, failure_tag, failures_, &requests[peer]);
  }
  const Backoff backoff;
  int complete = 0;
  while (MPI_Testall(size_, requests.data(), &complete, MPI_STATUSES_IGNORE) == MPI_SUCCESS && complete == 0 &&
         backoff.waited_s() < farewell_s)
    backoff.pause();
}

MpiSession::MpiSession() : exit_code_(static_cast<int>(ExitCode::solver_failed)) {
  // Dies with mpirun: it starts the ranks of its machine itself, and kill -9 leaves it no time to stop them.
  if (std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr) prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_TIMERSLACK, 1000UL);  // sleeps of the polled waits last as long as asked for, not up to 50 µs longer
  std::signal(SIGXFSZ, SIG_IGN);     // a file that may not grow is a full disk, not the end
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

}  // namespace copepod::fluid
