#include "transport/connections.hpp"

#include <algorithm>
#include <array>
#include <netdb.h>
#include <sys/socket.h>
#include <tuple>

#include "system/block_signals.hpp"

namespace copepod::transport {

namespace {

constexpr std::chrono::milliseconds kLook{500};
constexpr std::size_t kMostRemarks = 64;  ///< that wait to be read
constexpr std::chrono::seconds kStalledAfter{3};

/// Address of the other end: "10.0.0.7:4711", or what there is instead.
std::string address_of(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (getpeername(descriptor, generic, &size) != 0 || getnameinfo(generic, size, host.data(), host.size(), port.data(),
                                                                  port.size(), NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return "an unknown address";
  return std::string(host.data()) + ":" + port.data();
}

}  // namespace

Connections::Connections(zmq::context_t& context, zmq::socket_t& watched)
    : monitor_(context, watched, "router-monitor", kLook), thread_([this] { watch(); }) {}

Connections::~Connections() {
  is_over_ = true;
  monitor_.stop();  // ends the thread's wait
  thread_.join();
}

void Connections::spoke(const std::string& peer, int descriptor) {
  const std::lock_guard lock(mutex_);
  ++messages_;
  if (const auto found = standing_.find(descriptor); found != standing_.end()) found->second.heard = messages_;
  last_[peer] = descriptor;
}

bool Connections::connected(const std::string& peer) {
  const std::lock_guard lock(mutex_);
  const auto found = last_.find(peer);
  return found != last_.end() && standing_.contains(found->second);
}

void Connections::remark(std::string text) {
  const std::lock_guard lock(mutex_);
  keep(std::move(text));
}

std::string Connections::next_remark() {
  const std::lock_guard lock(mutex_);
  if (remarks_.empty()) return {};
  std::string remark = std::move(remarks_.front());
  remarks_.pop_front();
  return remark;
}

void Connections::watch() {
  block_signals();
  for (int descriptor = -1; !is_over_;) {
    const ConnectionMonitor::Event event = monitor_.next(descriptor);
    const std::lock_guard lock(mutex_);
    switch (event) {
      case ConnectionMonitor::Event::stopped:
        return;
      case ConnectionMonitor::Event::opened:
        opened(descriptor);
        break;
      case ConnectionMonitor::Event::closed:
        closed(descriptor);
        break;
      case ConnectionMonitor::Event::broken_off:
        keep("A connection was given up (its handshake was not completed: another program, or other keys).");
        break;
      default:
        note_stalled();
        break;
    }
  }
}

void Connections::opened(int descriptor) {
  const auto speaks_on_it = [descriptor](const auto& last) { return last.second == descriptor; };
  const bool is_heard = std::any_of(last_.begin(), last_.end(), speaks_on_it);  // its first message was faster
  standing_[descriptor] = {Clock::now(), is_heard ? messages_ : 0};
  if (standing_.size() > kMost) close_one();
}

void Connections::closed(int descriptor) {
  standing_.erase(descriptor);
  // The kernel will reuse the number: no peer may seem connected by it.
  std::erase_if(last_, [descriptor](const auto& last) { return last.second == descriptor; });
}

/// ZeroMQ sees that the connection ended, and frees the descriptor.
void Connections::close_one() {
  const auto longest_silent = std::min_element(standing_.begin(), standing_.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second.heard, a.second.opened) < std::tie(b.second.heard, b.second.opened);
  });
  const int descriptor = longest_silent->first;
  keep("A connection from " + address_of(descriptor) + " was closed (there were more than " + std::to_string(kMost) +
       ": other programs).");
  shutdown(descriptor, SHUT_RDWR);
  closed(descriptor);
}

void Connections::note_stalled() {
  for (auto& [descriptor, connection] : standing_) {
    const bool is_late = Clock::now() - connection.opened > kStalledAfter;
    if (connection.heard != 0 || connection.is_stalled || !is_late) continue;
    connection.is_stalled = true;
    keep("A connection from " + address_of(descriptor) +
         " has not sent a message (another program, or a component that hangs).");
  }
}

void Connections::keep(std::string remark) {
  if (remarks_.size() < kMostRemarks) remarks_.push_back(std::move(remark));
}

}  // namespace copepod::transport
