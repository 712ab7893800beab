#include <filesystem>
#include <optional>

#include <zmq.hpp>

#include "contract/errors.hpp"
#include "system/storage_errno.hpp"
#include "transport/authenticator.hpp"
#include "transport/connections.hpp"
#include "transport/endpoint.hpp"
#include "transport/lock_file.hpp"
#include "transport/patient_receiver.hpp"
#include "transport/zeromq.hpp"

namespace copepod::transport {

namespace {

constexpr int kRouterLingerMs = 1000;  ///< for the last messages of a coupler that ends

constexpr std::uint64_t kMessagesPerAuthentication = 64;  ///< where there is no quiet moment for it

class ZeroMqRouter final : public Router {
 public:
  ZeroMqRouter(const std::string& endpoint, const std::optional<CouplerKeys>& keys)
      : lock_(lock_for(endpoint)),
        context_(1),
        socket_(context_, zmq::socket_type::router),
        connections_(context_, socket_) {
    require_keys_off_this_machine(endpoint, keys.has_value());
    if (keys) use(*keys);
    socket_.set(zmq::sockopt::linger, kRouterLingerMs);
    socket_.set(zmq::sockopt::maxmsgsize, kLargestMessage);
    socket_.set(zmq::sockopt::router_mandatory,
                true);                                 // sending to an absent peer is an error, not a silent loss
    socket_.set(zmq::sockopt::router_handover, true);  // a peer that comes back keeps its name
    socket_.set(zmq::sockopt::sndtimeo, 0);            // a peer that reads nothing must not hold up the others
    try {
      const std::string address = with_numeric_host(endpoint);
      socket_.set(zmq::sockopt::ipv6, address.starts_with("tcp://["));
      socket_.bind(address);
    } catch (const zmq::error_t& error) {
      if (is_storage_errno(error.num()) && error.num() != EIO)  // EIO: a file system without sockets
        throw StorageError("The socket " + endpoint + " cannot be made (" + error.what() +
                           "). Free space and inodes on that disk.");
      throw Refused("The address " + endpoint + " cannot be bound (" + error.what() +
                    "). Free it or choose another one.");
    }
  }

  bool receive(Frame& frame, Duration wait) override {
    const bool is_quiet = !receiver_.receive(socket_, peer_, wait);
    if (authenticator_ && (is_quiet || ++messages_ % kMessagesPerAuthentication == 0)) authenticate();
    return !is_quiet && take(frame);
  }

  std::string next_remark() override { return connections_.next_remark(); }

  bool send(const std::string& peer, Bytes bytes) override {
    try {
      if (!socket_.send(zmq::const_buffer(peer.data(), peer.size()), zmq::send_flags::sndmore)) return false;
      return socket_.send(zmq::const_buffer(bytes.data(), bytes.size()), zmq::send_flags::none).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() == EHOSTUNREACH) return false;
      throw;
    }
  }

  bool connected(const std::string& peer) override { return connections_.connected(peer); }

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
      connections_.remark("A connection from " + address + " was refused (its key is not one of this run).");
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
    connections_.spoke(frame.peer, zmq_msg_get(message_.handle(), ZMQ_SRCFD));
    frame.content = {message_.data<std::byte>(), message_.size()};
    return true;
  }

  std::optional<LockFile> lock_;
  zmq::context_t context_;
  zmq::socket_t socket_;
  PatientReceiver receiver_;
  std::optional<Authenticator> authenticator_;
  std::uint64_t messages_ = 0;
  zmq::message_t peer_;
  zmq::message_t message_;
  Connections connections_;  // ends first, with its thread
};

}  // namespace

std::unique_ptr<Router> bind_router(const std::string& endpoint, const std::optional<CouplerKeys>& keys) {
  return std::make_unique<ZeroMqRouter>(endpoint, keys);
}

}  // namespace copepod::transport
