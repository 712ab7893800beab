#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <chrono>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <sys/socket.h>

#include <zmq.hpp>

#include "contract/errors.hpp"
#include "system/storage_errno.hpp"
#include "transport/authenticator.hpp"
#include "transport/connection_monitor.hpp"
#include "transport/endpoint.hpp"
#include "transport/lock_file.hpp"
#include "transport/patient_receiver.hpp"
#include "transport/zeromq.hpp"

namespace copepod::transport {

namespace {

constexpr int kRouterLingerMs = 1000;  ///< for the last messages of a coupler that ends

constexpr std::uint64_t kMessagesPerAuthentication = 64;  ///< where there is no quiet moment for it
constexpr std::size_t kMostRemarks = 64;                  ///< that wait to be read
constexpr std::chrono::seconds kStalledAfter{3};

/// Address of the other end: "10.0.0.7:4711", or what there is instead.
std::string address_of(int descriptor) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  std::array<char, INET_ADDRSTRLEN> text{};
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0 || address.sin_family != AF_INET ||
      inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size()) == nullptr)
    return "an unknown address";
  return std::string(text.data()) + ":" + std::to_string(ntohs(address.sin_port));
}

/// Which connection, by file descriptor, each peer spoke on last, and which connections stand.
class ConnectionBook {
 public:
  void opened(int descriptor) {
    standing_.insert(descriptor);
    const auto speaks_on_it = [descriptor](const auto& last) { return last.second == descriptor; };
    if (std::none_of(last_.begin(), last_.end(), speaks_on_it)) unheard_[descriptor] = Clock::now();
  }

  void closed(int descriptor) {
    standing_.erase(descriptor);
    unheard_.erase(descriptor);
    // The kernel will reuse the number: no peer may seem connected by it.
    for (auto& [peer, last] : last_) {
      if (last == descriptor) last = -1;
    }
  }

  void spoke(const std::string& peer, int descriptor) {
    if (!unheard_.empty()) unheard_.erase(descriptor);
    const auto found = last_.find(peer);
    if (found == last_.end()) {
      last_.emplace(peer, descriptor);
    } else {
      found->second = descriptor;
    }
  }

  [[nodiscard]] bool connected(const std::string& peer) const {
    const auto found = last_.find(peer);
    return found != last_.end() && standing_.contains(found->second);
  }

  /// A connection on which no message has come for too long; each is returned once.
  std::optional<int> next_stalled() {
    const auto oldest = std::min_element(unheard_.begin(), unheard_.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (oldest == unheard_.end() || Clock::now() - oldest->second < kStalledAfter) return std::nullopt;
    const int descriptor = oldest->first;
    unheard_.erase(oldest);
    return descriptor;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::set<int> standing_;
  std::map<int, Clock::time_point> unheard_;  ///< since they were opened
  std::map<std::string, int> last_;
};

class ZeroMqRouter final : public Router {
 public:
  ZeroMqRouter(const std::string& endpoint, const std::optional<CouplerKeys>& keys)
      : lock_(lock_for(endpoint)),
        context_(1),
        socket_(context_, zmq::socket_type::router),
        monitor_(context_, socket_, "router-monitor") {
    require_keys_off_this_machine(endpoint, keys.has_value());
    if (keys) use(*keys);
    socket_.set(zmq::sockopt::linger, kRouterLingerMs);
    socket_.set(zmq::sockopt::maxmsgsize, kLargestMessage);
    socket_.set(zmq::sockopt::router_mandatory,
                true);                                 // sending to an absent peer is an error, not a silent loss
    socket_.set(zmq::sockopt::router_handover, true);  // a peer that comes back keeps its name
    socket_.set(zmq::sockopt::sndtimeo, 1000);
    try {
      socket_.bind(endpoint);
    } catch (const zmq::error_t& error) {
      if (is_storage_errno(error.num()))
        throw StorageError("The socket " + endpoint + " cannot be made (" + error.what() +
                           "). Free space and inodes on that disk.");
      throw Refused("The address " + endpoint + " cannot be bound (" + error.what() +
                    "). Free it or choose another one.");
    }
  }

  bool receive(Frame& frame, Duration wait) override {
    const bool is_quiet = !receiver_.receive(socket_, peer_, wait);
    if (authenticator_ && (is_quiet || ++messages_ % kMessagesPerAuthentication == 0)) authenticate();
    if (!is_quiet) return take(frame);
    read_monitor();
    while (const std::optional<int> stalled = book_.next_stalled()) {
      remark("A connection from " + address_of(*stalled) +
             " has not sent a message (another program, or a component that hangs).");
    }
    return false;
  }

  std::string next_remark() override {
    if (remarks_.empty()) return {};
    std::string remark = std::move(remarks_.front());
    remarks_.pop_front();
    return remark;
  }

  bool send(const std::string& peer, Bytes bytes) override {
    try {
      if (!socket_.send(zmq::const_buffer(peer.data(), peer.size()), zmq::send_flags::sndmore)) return false;
      return socket_.send(zmq::const_buffer(bytes.data(), bytes.size()), zmq::send_flags::none).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() == EHOSTUNREACH) return false;
      throw;
    }
  }

  bool connected(const std::string& peer) override {
    read_monitor();
    return book_.connected(peer);
  }

 private:
  static std::optional<LockFile> lock_for(const std::string& endpoint) {
    check_endpoint(endpoint);
    const std::string path = ipc_path(endpoint);
    if (path.empty()) return std::nullopt;
    std::error_code ignored;
    const auto kind = std::filesystem::symlink_status(path, ignored).type();  // ZeroMQ removes what it finds there
    if (kind != std::filesystem::file_type::not_found && kind != std::filesystem::file_type::socket) {
      throw Refused("The address " + endpoint +
                    " cannot be bound (there is a file of that name, not a socket). Choose another one.");
    }
    return std::optional<LockFile>(std::in_place, path + ".lock");
  }

  void use(const CouplerKeys& keys) {
    authenticator_.emplace(context_, keys.admitted);
    socket_.set(zmq::sockopt::zap_domain, "copepod");
    socket_.set(zmq::sockopt::curve_server, true);
    socket_.set(zmq::sockopt::curve_secretkey, keys.secret);
  }

  void authenticate() {
    for (const std::string& address : authenticator_->answer())
      remark("A connection from " + address + " was refused (its key is not one of this run).");
  }

  void remark(std::string text) {
    if (remarks_.size() < kMostRemarks) remarks_.push_back(std::move(text));
  }

  /// Takes frames (peer, message); anything of another shape is not a message of the protocol.
  bool take(Frame& frame) {
    if (!peer_.more()) return false;
    static_cast<void>(socket_.recv(message_, zmq::recv_flags::dontwait));
    const bool has_two_parts = !message_.more();
    while (message_.more()) static_cast<void>(socket_.recv(message_, zmq::recv_flags::dontwait));
    if (!has_two_parts) return false;
    frame.peer.assign(static_cast<const char*>(peer_.data()), peer_.size());
    if (authenticator_) frame.identity = message_.gets("User-Id");
    book_.spoke(frame.peer, zmq_msg_get(message_.handle(), ZMQ_SRCFD));
    frame.content = {message_.data<std::byte>(), message_.size()};
    return true;
  }

  void read_monitor() {
    int descriptor = -1;
    for (;;) {
      switch (monitor_.next(descriptor)) {
        case ConnectionMonitor::Event::none:
          return;
        case ConnectionMonitor::Event::opened:
          book_.opened(descriptor);
          break;
        case ConnectionMonitor::Event::closed:
          book_.closed(descriptor);
          break;
        case ConnectionMonitor::Event::broken_off:
          remark("A connection was given up (its handshake was not completed: another program, or other keys).");
          break;
        default:
          break;
      }
    }
  }

  std::optional<LockFile> lock_;
  zmq::context_t context_;
  zmq::socket_t socket_;
  PatientReceiver receiver_;
  ConnectionMonitor monitor_;
  std::optional<Authenticator> authenticator_;
  ConnectionBook book_;
  std::uint64_t messages_ = 0;
  std::deque<std::string> remarks_;
  zmq::message_t peer_;
  zmq::message_t message_;
};

}  // namespace

std::unique_ptr<Router> bind_router(const std::string& endpoint, const std::optional<CouplerKeys>& keys) {
  return std::make_unique<ZeroMqRouter>(endpoint, keys);
}

}  // namespace copepod::transport
