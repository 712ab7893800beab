#include "transport/connection_monitor.hpp"

#include <cstring>

#include "contract/errors.hpp"

namespace copepod::transport {

namespace {

constexpr int kOpened = ZMQ_EVENT_CONNECTED | ZMQ_EVENT_ACCEPTED;
constexpr int kClosed = ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_CLOSED;
constexpr int kTurnedAway = ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL;
constexpr int kBrokenOff = ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
constexpr int kEvents = kOpened | kClosed | kTurnedAway | kBrokenOff | ZMQ_EVENT_MONITOR_STOPPED;

}  // namespace

ConnectionMonitor::ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched, const std::string& name,
                                     std::chrono::milliseconds wait)
    : watched_(watched), socket_(context, zmq::socket_type::pair) {
  const std::string address = "inproc://" + name;
  if (zmq_socket_monitor(watched.handle(), address.c_str(), kEvents) != 0) {
    throw Refused(std::string("The connections cannot be watched (") + zmq_strerror(zmq_errno()) +
                  "). Raise the limit of open files.");
  }
  socket_.set(zmq::sockopt::linger, 0);
  socket_.set(zmq::sockopt::rcvtimeo, static_cast<int>(wait.count()));
  socket_.connect(address);
}

ConnectionMonitor::~ConnectionMonitor() { stop(); }

void ConnectionMonitor::stop() { zmq_socket_monitor(watched_.handle(), nullptr, 0); }

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

}  // namespace copepod::transport
