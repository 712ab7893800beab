#include <map>
#include <optional>
#include <set>

#include <zmq.hpp>

#include "contract/errors.hpp"
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

/// Which connection, by file descriptor, each peer spoke on last, and which connections stand.
class ConnectionBook {
 public:
  void opened(int descriptor) { standing_.insert(descriptor); }

  void closed(int descriptor) {
    standing_.erase(descriptor);
    // The kernel will reuse the number: no peer may seem connected by it.
    for (auto& [peer, last] : last_) {
      if (last == descriptor) last = -1;
    }
  }

  void spoke(const std::string& peer, int descriptor) {
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

 private:
  std::set<int> standing_;
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
      throw Refused("The address " + endpoint + " cannot be bound (" + error.what() +
                    "). Free it or choose another one.");
    }
  }

  bool receive(Frame& frame, Duration wait) override {
    const bool is_quiet = !receiver_.receive(socket_, peer_, wait);
    if (authenticator_ && (is_quiet || ++messages_ % kMessagesPerAuthentication == 0)) authenticator_->answer();
    if (!is_quiet) return take(frame);
    read_monitor();
    return false;
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
    return std::optional<LockFile>(std::in_place, path + ".lock");
  }

  void use(const CouplerKeys& keys) {
    authenticator_.emplace(context_, keys.admitted);
    socket_.set(zmq::sockopt::zap_domain, "copepod");
    socket_.set(zmq::sockopt::curve_server, true);
    socket_.set(zmq::sockopt::curve_secretkey, keys.secret);
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
  zmq::message_t peer_;
  zmq::message_t message_;
};

}  // namespace

std::unique_ptr<Router> bind_router(const std::string& endpoint, const std::optional<CouplerKeys>& keys) {
  return std::make_unique<ZeroMqRouter>(endpoint, keys);
}

}  // namespace copepod::transport
