#include "ranks/thread_ranks.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>

#include "contract/errors.hpp"
#include "ranks/communicator.hpp"
#include "ranks/rank_failure.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

namespace {

constexpr std::chrono::milliseconds look_every{100};  ///< of a sleeping rank: for a request to stop

}  // namespace

/// One side of a message, in the memory of the rank that posted it; takes itself back if it is destroyed before it is
/// complete, so that nothing is written into buffers that a failing solver has freed.
class ThreadRanks::Posting {
 public:
  ~Posting();

  [[nodiscard]] bool is_open() const { return open_.load(std::memory_order_acquire); }
  /// The other side is there, and neither of the two ranks copies so far.
  [[nodiscard]] bool is_matched() const { return match_.load(std::memory_order_relaxed) != nullptr; }
  /// Copies the message if it is matched.
  void deliver();

 private:
  friend Channel;
  void take(std::span<const std::byte> data) {
    if (resized_ != nullptr) {
      resized_->resize(data.size());
      target_ = *resized_;
    }
    assert(data.size() == target_.size());
    std::ranges::copy(data, target_.begin());
  }
  void close() { open_.store(false, std::memory_order_release); }  // from here on it may be gone

  std::atomic<bool> open_{false};
  std::atomic<Posting*> match_{nullptr};  ///< changes under the channel's mutex
  Channel* channel_ = nullptr;
  bool sends_ = false;
  std::span<const std::byte> source_;          ///< of a sender
  std::span<std::byte> target_;                ///< of a receiver
  std::vector<std::byte>* resized_ = nullptr;  ///< of one that takes any size
};

/// Messages from one rank to another: their two sides match in the order in which they were posted.
class ThreadRanks::Channel {
 public:
  Channel(Rank& sender, Rank& receiver) : sender_(sender), receiver_(receiver) {}

  void send(Posting& posting, std::span<const std::byte> data);
  void receive(Posting& posting, std::span<std::byte> data);
  /// Of whatever size it is sent with.
  void receive(Posting& posting, std::vector<std::byte>& data);
  /// Sends a copy once the one before has been received.
  void send_copy(std::span<const std::byte> data);
  /// Copies what a posting and its match hold, unless the other rank does so already.
  void deliver(Posting& posting);
  /// On return nothing reads or writes the posting's buffer any more.
  void withdraw(Posting& posting);

 private:
  using Postings = std::deque<Posting*>;

  /// Matches it with the first of `others`, or lets it wait in `own`.
  /// @return whether there was one
  bool match(Posting& posting, Postings& own, Postings& others);

  Rank& sender_;
  Rank& receiver_;
  std::mutex mutex_;
  Postings sends_;     ///< without a receiver so far
  Postings receives_;  ///< without a sender so far
  std::vector<std::byte> copy_;
  Posting posted_copy_;
};

/// Communicator of one rank.
class ThreadRanks::Rank final : public Communicator {
 public:
  Rank(Team& team, int rank, SolverContext& context) : Communicator(context), team_(team), rank_(rank) {}

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override;
  void broadcast(std::span<std::byte> data) override;
  void reduce_to_leader(std::span<std::int64_t> values, Reduction reduction) override;
  [[nodiscard]] std::function<void()> start_exchange(std::span<const Message> messages) override;
  [[nodiscard]] std::function<void()> start_send(int peer, std::span<const std::byte> data) override;
  void receive(int peer, std::vector<std::byte>& data) override;
  void report_failure(const FailureReport& report) override;

  void wait_for(Posting& posting);
  void wake();
  void throw_if_failed() const;

 private:
  Team& team_;
  int rank_;
  std::vector<std::int64_t> received_;
  std::mutex mutex_;
  std::condition_variable woken_;
};

/// All ranks, and what they share.
class ThreadRanks::Team {
 public:
  enum class Purpose { exchange, collective, single };
  static constexpr int purposes = static_cast<int>(Purpose::single) + 1;

  Team(int size, SolverContext& leader, const std::function<void(Communicator&)>& follow);

  [[nodiscard]] int size() const { return static_cast<int>(ranks_.size()); }
  [[nodiscard]] Rank& rank(int rank) { return ranks_[rank]; }
  [[nodiscard]] Channel& channel(Purpose purpose, int from, int to) {
    const int index = (from * size() + to) * purposes + static_cast<int>(purpose);
    return channels_[index];
  }

  /// The first report counts.
  void fail(const FailureReport& report);
  /// Null as long as no rank failed.
  [[nodiscard]] const FailureReport* failure() const {
    return failed_.load(std::memory_order_acquire) ? &failure_ : nullptr;
  }

 private:
  std::deque<SolverContext> contexts_;  ///< of all ranks but 0
  std::deque<Rank> ranks_;
  std::deque<Channel> channels_;
  std::mutex mutex_;
  FailureReport failure_;
  std::atomic<bool> failed_{false};
  std::vector<std::jthread> threads_;  ///< last: they end before what they use
};

ThreadRanks::Posting::~Posting() {
  if (is_open()) channel_->withdraw(*this);
}

void ThreadRanks::Posting::deliver() {
  if (is_matched()) channel_->deliver(*this);
}

bool ThreadRanks::Channel::match(Posting& posting, Postings& own, Postings& others) {
  const std::lock_guard lock(mutex_);
  posting.channel_ = this;
  posting.open_.store(true, std::memory_order_relaxed);
  if (others.empty()) {
    own.push_back(&posting);
    return false;
  }
  posting.match_ = others.front();
  others.front()->match_ = &posting;
  others.pop_front();
  return true;
}

void ThreadRanks::Channel::send(Posting& posting, std::span<const std::byte> data) {
  posting.sends_ = true;
  posting.source_ = data;
  if (match(posting, sends_, receives_)) receiver_.wake();
}

void ThreadRanks::Channel::receive(Posting& posting, std::span<std::byte> data) {
  posting.target_ = data;
  if (match(posting, receives_, sends_)) sender_.wake();
}

void ThreadRanks::Channel::deliver(Posting& posting) {
  Posting* other = nullptr;
  {
    const std::lock_guard lock(mutex_);
    other = posting.match_;
    if (other == nullptr) return;
    posting.match_ = other->match_ = nullptr;
  }
  if (posting.sends_)
    other->take(posting.source_);
  else
    posting.take(other->source_);
  other->close();
  (posting.sends_ ? receiver_ : sender_).wake();
  posting.close();
}

void ThreadRanks::Channel::receive(Posting& posting, std::vector<std::byte>& data) {
  posting.resized_ = &data;
  receive(posting, std::span<std::byte>());
}

void ThreadRanks::Channel::withdraw(Posting& posting) {
  {
    const std::lock_guard lock(mutex_);
    if (std::erase(sends_, &posting) + std::erase(receives_, &posting) > 0) return;
  }
  while (posting.is_open()) {  // the other rank copies, unless this one does
    posting.deliver();
    std::this_thread::yield();
  }
}

void ThreadRanks::Channel::send_copy(std::span<const std::byte> data) {
  sender_.wait_for(posted_copy_);
  copy_.assign(data.begin(), data.end());
  send(posted_copy_, copy_);
}

int ThreadRanks::Rank::size() const { return team_.size(); }

void ThreadRanks::Rank::throw_if_failed() const {
  if (const FailureReport* failure = team_.failure()) throw PeerFailed(*failure);
}

void ThreadRanks::Rank::wake() {
  { const std::lock_guard lock(mutex_); }  // it either has not looked yet, or sleeps already
  woken_.notify_one();
}

void ThreadRanks::Rank::wait_for(Posting& posting) {
  const double start_s = now_s();
  while (posting.is_open()) {
    posting.deliver();
    throw_if_failed();
    if (const int code = context().stop_requested(); code != 0)
      throw Error(static_cast<ExitCode>(code),
                  "stopped while waiting for another rank (the run was ended). See the coupler's log.", rank_);
    if (now_s() - start_s < spin_s) {
      std::this_thread::yield();
      continue;
    }
    std::unique_lock lock(mutex_);
    woken_.wait_for(lock, look_every,
                    [&] { return !posting.is_open() || posting.is_matched() || team_.failure() != nullptr; });
  }
}

void ThreadRanks::Rank::broadcast(std::span<std::byte> data) {
  throw_if_failed();
  if (rank_ == 0) {
    for (int peer = 1; peer < size(); ++peer) team_.channel(Team::Purpose::collective, 0, peer).send_copy(data);
  } else {
    Posting posting;
    team_.channel(Team::Purpose::collective, 0, rank_).receive(posting, data);
    wait_for(posting);
  }
}

void ThreadRanks::Rank::reduce_to_leader(std::span<std::int64_t> values, Reduction reduction) {
  throw_if_failed();
  if (rank_ != 0) {
    team_.channel(Team::Purpose::collective, rank_, 0).send_copy(std::as_bytes(values));
    return;
  }
  // Unsigned sums: the same bits as signed ones, and defined where digests wrap around.
  const auto combine = [reduction](std::int64_t a, std::int64_t b) {
    return reduction == Reduction::max
               ? std::max(a, b)
               : static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
  };
  received_.resize(values.size());
  for (int peer = 1; peer < size(); ++peer) {
    Posting posting;
    team_.channel(Team::Purpose::collective, peer, 0).receive(posting, std::as_writable_bytes(std::span(received_)));
    wait_for(posting);
    std::ranges::transform(values, received_, values.begin(), combine);
  }
}

std::function<void()> ThreadRanks::Rank::start_exchange(std::span<const Message> messages) {
  throw_if_failed();
  // std::function requires a copyable target, hence shared ownership despite a single owner.
  const auto postings = std::make_shared<std::vector<Posting>>(2 * messages.size());
  auto posting = postings->begin();
  for (const Message& message : messages)
    team_.channel(Team::Purpose::exchange, message.peer, rank_).receive(*posting++, message.receive);
  for (const Message& message : messages)
    team_.channel(Team::Purpose::exchange, rank_, message.peer).send(*posting++, message.send);
  return [this, postings] {
    throw_if_failed();
    for (Posting& each : *postings) wait_for(each);
  };
}

std::function<void()> ThreadRanks::Rank::start_send(int peer, std::span<const std::byte> data) {
  throw_if_failed();
  const auto posting = std::make_shared<Posting>();
  team_.channel(Team::Purpose::single, rank_, peer).send(*posting, data);
  return [this, posting] { wait_for(*posting); };
}

void ThreadRanks::Rank::receive(int peer, std::vector<std::byte>& data) {
  throw_if_failed();
  Posting posting;
  team_.channel(Team::Purpose::single, peer, rank_).receive(posting, data);
  wait_for(posting);
}

void ThreadRanks::Rank::report_failure(const FailureReport& report) { team_.fail(report); }

ThreadRanks::Team::Team(int size, SolverContext& leader, const std::function<void(Communicator&)>& follow)
    : contexts_(size - 1) {
  ranks_.emplace_back(*this, 0, leader);
  for (SolverContext& context : contexts_) ranks_.emplace_back(*this, static_cast<int>(ranks_.size()), context);
  for (Rank& sender : ranks_)
    for (Rank& receiver : ranks_)
      for (int purpose = 0; purpose < purposes; ++purpose) channels_.emplace_back(sender, receiver);
  try {
    for (int rank = 1; rank < size; ++rank)
      threads_.emplace_back([this, rank, follow] {
        block_signals();
        follow(this->rank(rank));
      });
  } catch (const std::system_error& error) {
    const ComponentLost loss("the ranks cannot be started (" + std::to_string(size) + " threads: " + error.what() +
                             "). Use fewer ranks.");
    fail(failure_of_rank(loss, 0, -1));  // lets those that are there end
    throw ComponentLost(loss);
  }
}

void ThreadRanks::Team::fail(const FailureReport& report) {
  {
    const std::lock_guard lock(mutex_);
    if (failed_.load(std::memory_order_relaxed)) return;
    failure_ = report;
    failed_.store(true, std::memory_order_release);
  }
  for (Rank& rank : ranks_) rank.wake();
}

ThreadRanks::ThreadRanks(int size, SolverContext& leader, const std::function<void(Communicator&)>& follow)
    : team_(std::make_unique<Team>(size, leader, follow)) {}

ThreadRanks::~ThreadRanks() = default;

Communicator& ThreadRanks::leader() { return team_->rank(0); }

}  // namespace copepod::fluid
