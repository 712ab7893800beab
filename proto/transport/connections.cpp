#include "transport/connections.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <netdb.h>
#include <sys/socket.h>
#include <tuple>

#include "contract/errors.hpp"
#include "system/process.hpp"

namespace copepod::transport {

namespace {

constexpr int kOpened = ZMQ_EVENT_CONNECTED | ZMQ_EVENT_ACCEPTED;
constexpr int kClosed = ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_CLOSED;
constexpr int kTurnedAway = ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL;
constexpr int kBrokenOff = ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
constexpr int kEvents = kOpened | kClosed | kTurnedAway | kBrokenOff | ZMQ_EVENT_MONITOR_STOPPED;

/// Frames of a request: version, id, domain, address, routing id, mechanism, then credentials [RFC 27].
enum Place : std::size_t { version = 0, request_id = 1, address = 3, mechanism = 5, credential = 6, count = 7 };

std::string as_bytes(const std::string& z85_key) {
  std::array<std::uint8_t, 32> bytes{};
  zmq_z85_decode(bytes.data(), z85_key.c_str());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

constexpr std::chrono::milliseconds kLook{500};
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

ConnectionMonitor::ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched, const std::string& name,
                                     std::chrono::milliseconds wait)
    : watched_(watched), socket_(context, zmq::socket_type::pair) {
  const std::string address = "inproc://" + name;
  if (zmq_socket_monitor(watched.handle(), address.c_str(), kEvents) != 0)
    throw Refused(std::string("The connections cannot be watched (") + zmq_strerror(zmq_errno()) +
                  "). Raise the limit of open files.");
  socket_.set(zmq::sockopt::linger, 0);
  socket_.set(zmq::sockopt::rcvtimeo, static_cast<int>(wait.count()));
  socket_.connect(address);
}

ConnectionMonitor::Event ConnectionMonitor::next(int& descriptor) {
  // Frame 1: event (16 bits), value (32 bits); frame 2: address [zmq_socket_monitor(3)].
  zmq::message_t event_frame;
  zmq::message_t address_frame;
  try {
    if (!socket_.recv(event_frame)) return Event::none;
  } catch (const zmq::error_t& error) {
    return error.num() == ETERM ? Event::stopped : Event::none;
  }
  static_cast<void>(socket_.recv(address_frame, zmq::recv_flags::dontwait));
  std::uint16_t event = 0;
  std::int32_t value = 0;
  if (event_frame.size() < sizeof(event) + sizeof(value)) return Event::other;
  std::memcpy(&event, event_frame.data(), sizeof(event));
  std::memcpy(&value, static_cast<const char*>(event_frame.data()) + sizeof(event), sizeof(value));
  descriptor = value;
  if (event == ZMQ_EVENT_MONITOR_STOPPED) return Event::stopped;
  if ((event & kOpened) != 0) return Event::opened;
  if ((event & kClosed) != 0) return Event::closed;
  if ((event & kTurnedAway) != 0) return Event::turned_away;
  if ((event & kBrokenOff) != 0) return Event::broken_off;
  return Event::other;
}

Authenticator::Authenticator(zmq::context_t& context, const std::map<std::string, std::string>& admitted)
    : socket_(context, zmq::socket_type::rep) {
  for (const auto& [key, name] : admitted) admitted_[as_bytes(key)] = name;
  socket_.set(zmq::sockopt::linger, 0);
  socket_.bind("inproc://zeromq.zap.01");
}

std::vector<std::string> Authenticator::answer() {
  std::vector<std::string> rejected;
  zmq::message_t part;
  while (socket_.recv(part, zmq::recv_flags::dontwait)) {
    std::vector<std::string> request{part.to_string()};
    while (part.more() && socket_.recv(part)) request.push_back(part.to_string());
    request.resize(Place::count);
    const bool has_key = request[Place::mechanism] == "CURVE";
    const auto found = has_key ? admitted_.find(request[Place::credential]) : admitted_.end();
    const bool is_admitted = found != admitted_.end();
    if (!is_admitted) rejected.push_back(request[Place::address]);
    const std::array<std::string, 6> reply = {request[Place::version],          request[Place::request_id],
                                              is_admitted ? "200" : "400",      is_admitted ? "" : "unknown key",
                                              is_admitted ? found->second : "", ""};
    for (std::size_t i = 0; i < reply.size(); ++i) {
      const bool is_last = i + 1 == reply.size();
      socket_.send(zmq::buffer(reply[i]), is_last ? zmq::send_flags::none : zmq::send_flags::sndmore);
    }
  }
  return rejected;
}

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
    if (event == ConnectionMonitor::Event::stopped) return;
    if (event == ConnectionMonitor::Event::opened)
      opened(descriptor);
    else if (event == ConnectionMonitor::Event::closed)
      closed(descriptor);
    else if (event == ConnectionMonitor::Event::broken_off)
      keep("A connection was given up (its handshake was not completed: another program, or other keys).");
    else
      note_stalled();
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

}  // namespace copepod::transport
