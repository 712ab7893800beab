#include "in_memory.hpp"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace copepod::transport {

struct InMemoryWire::State {
  struct Peer {
    std::deque<std::vector<std::byte>> inbox;
    bool connected = true;
    bool lose_next_to = false;
    bool lose_next_from = false;
  };
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::string, Peer> peers;
  std::deque<std::pair<std::string, std::vector<std::byte>>> router_inbox;
};

namespace {

using Message = std::vector<std::byte>;

Message copy(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

/// Both ends lock the same state; nested so that they may name it.
template <class State>
class InMemoryRouter final : public Router {
 public:
  explicit InMemoryRouter(std::shared_ptr<State> state) : state_(std::move(state)) {}

  bool receive(Frame& frame, Duration wait) override {
    std::unique_lock lock(state_->mutex);
    if (!state_->changed.wait_for(lock, wait, [this] { return !state_->router_inbox.empty(); })) return false;
    frame.peer = state_->router_inbox.front().first;
    message_ = std::move(state_->router_inbox.front().second);
    frame.content = message_;
    state_->router_inbox.pop_front();
    return true;
  }

  bool send(const std::string& peer, Bytes bytes) override {
    const std::lock_guard lock(state_->mutex);
    const auto found = state_->peers.find(peer);
    if (found == state_->peers.end() || !found->second.connected) return false;
    if (!std::exchange(found->second.lose_next_to, false)) found->second.inbox.push_back(copy(bytes));
    state_->changed.notify_all();
    return true;
  }

  bool connected(const std::string& peer) override {
    const std::lock_guard lock(state_->mutex);
    const auto found = state_->peers.find(peer);
    return found != state_->peers.end() && found->second.connected;
  }

 private:
  std::shared_ptr<State> state_;
  Message message_;
};

template <class State>
class InMemoryDealer final : public Dealer {
 public:
  InMemoryDealer(std::shared_ptr<State> state, std::string name) : state_(std::move(state)), name_(std::move(name)) {}

  ~InMemoryDealer() override {
    const std::lock_guard lock(state_->mutex);
    state_->peers[name_].connected = false;
    state_->changed.notify_all();
  }

  bool receive(Frame& frame, Duration wait) override {
    std::unique_lock lock(state_->mutex);
    auto& inbox = state_->peers[name_].inbox;
    if (!state_->changed.wait_for(lock, wait, [&inbox] { return !inbox.empty(); })) return false;
    message_ = std::move(inbox.front());
    frame.content = message_;
    inbox.pop_front();
    return true;
  }

  bool send(Bytes bytes) override {
    const std::lock_guard lock(state_->mutex);
    auto& peer = state_->peers[name_];
    if (!peer.connected) return true;  // as a socket would: queued, and lost
    if (!std::exchange(peer.lose_next_from, false)) state_->router_inbox.emplace_back(name_, copy(bytes));
    state_->changed.notify_all();
    return true;
  }

  bool connected() override {
    const std::lock_guard lock(state_->mutex);
    return state_->peers[name_].connected;
  }

 private:
  std::shared_ptr<State> state_;
  std::string name_;
  Message message_;
};

InMemoryWire::InMemoryWire() : state_(std::make_shared<State>()) {}
InMemoryWire::~InMemoryWire() = default;

std::unique_ptr<Router> InMemoryWire::make_router() { return std::make_unique<InMemoryRouter<State>>(state_); }

std::unique_ptr<Dealer> InMemoryWire::make_dealer(const std::string& name) {
  const std::lock_guard lock(state_->mutex);
  state_->peers[name] = {};
  return std::make_unique<InMemoryDealer<State>>(state_, name);
}

void InMemoryWire::disconnect(const std::string& name) {
  const std::lock_guard lock(state_->mutex);
  state_->peers[name].connected = false;
  state_->changed.notify_all();
}

void InMemoryWire::reconnect(const std::string& name) {
  const std::lock_guard lock(state_->mutex);
  state_->peers[name].connected = true;
  state_->changed.notify_all();
}

void InMemoryWire::lose_next_to(const std::string& name) {
  const std::lock_guard lock(state_->mutex);
  state_->peers[name].lose_next_to = true;
}

void InMemoryWire::lose_next_from(const std::string& name) {
  const std::lock_guard lock(state_->mutex);
  state_->peers[name].lose_next_from = true;
}

}  // namespace copepod::transport
