#include "transport/lanes.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include <zmq.hpp>

#include "contract/errors.hpp"
#include "system/durable_file.hpp"
#include "transport/connections.hpp"
#include "transport/endpoint.hpp"

namespace copepod::transport {

namespace {

constexpr const char* kRemedy = "Give the file that the deploy command made for this role.";

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw CaseError("The key file " + path + " is not usable (" + why + "). " + kRemedy);
}

void require_privacy(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) refuse(path, "it cannot be found");
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) refuse(path, "others may read it: chmod 600");
}

bool is_key(const std::string& text) {
  std::array<std::uint8_t, 32> bytes{};
  return text.size() == 40 && zmq_z85_decode(bytes.data(), text.c_str()) != nullptr;
}

using Words = std::map<std::string, std::string>;

/// Name and key of every line.
Words read_lines(const std::string& path) {
  require_privacy(path);
  Words lines;
  std::ifstream file(path);
  for (std::string name, key; file >> name >> key;) {
    if (!is_key(key)) refuse(path, "its entry " + name + " is not a key");
    lines[name] = key;
  }
  return lines;
}

std::string take(const Words& lines, const std::string& name, const std::string& path) {
  const auto found = lines.find(name);
  if (found == lines.end()) refuse(path, "it has no line '" + name + " KEY'");
  return found->second;
}

/// Receives with a deadline in the cheapest way (docs/decisions/how_the_data_lanes_wait.md): ZeroMQ's own
/// blocking receive, whose limit is set only when it changes. Polling would take three system calls instead
/// of one.
class PatientReceiver {
 public:
  /// The first part of the next message; false if none came within `wait`, or a signal came first.
  bool receive(zmq::socket_t& socket, zmq::message_t& part, Duration wait) {
    const auto limit = std::chrono::ceil<std::chrono::milliseconds>(std::max(wait, Duration::zero()));
    if (limit != limit_) {
      socket.set(zmq::sockopt::rcvtimeo, static_cast<int>(limit.count()));
      limit_ = limit;
    }
    try {
      return socket.recv(part).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
      return false;
    }
  }

 private:
  std::chrono::milliseconds limit_{-1};
};

constexpr int kDealerLingerMs = 500;  ///< for the last message of a component that ends
constexpr int kReconnectMs = 100;
constexpr int kMostBrokenHandshakes = 3;  ///< in a row, before the first one that succeeds

class ZeroMqDealer final : public Dealer {
 public:
  ZeroMqDealer(const std::string& endpoint, const std::string& name, const std::optional<ComponentKeys>& keys)
      : context_(1), socket_(context_, zmq::socket_type::dealer), monitor_(context_, socket_, "dealer-monitor") {
    check_endpoint(endpoint);
    require_keys_off_this_machine(endpoint, keys.has_value());
    if (keys) use(*keys);
    socket_.set(zmq::sockopt::linger, kDealerLingerMs);
    socket_.set(zmq::sockopt::maxmsgsize, kLargestMessage);
    socket_.set(zmq::sockopt::routing_id, name);
    socket_.set(zmq::sockopt::reconnect_ivl, kReconnectMs);
    socket_.set(zmq::sockopt::sndtimeo, 1000);
    path_ = ipc_path(endpoint);
    try {
      const std::string address = with_numeric_host(endpoint);
      socket_.set(zmq::sockopt::ipv6, address.starts_with("tcp://["));
      socket_.connect(address);
    } catch (const zmq::error_t& error) {
      throw CaseError("The endpoint " + endpoint + " cannot be connected to (" + error.what() +
                      "). Use the address that the coupler was given.");
    }
  }

  bool receive(Frame& frame, Duration wait) override {
    return receiver_.receive(socket_, message_, wait) && take(frame);
  }

  bool send(Bytes bytes) override {
    return socket_.send(zmq::const_buffer(bytes.data(), bytes.size()), zmq::send_flags::none).has_value();
  }

  bool connected() override {
    read_monitor();
    return connected_;
  }

  bool address_is_gone() override { return !path_.empty() && ::access(path_.c_str(), F_OK) != 0; }

  bool turned_away() override {
    read_monitor();
    return turned_away_ || broken_handshakes_ >= kMostBrokenHandshakes;
  }

 private:
  void use(const ComponentKeys& keys) {
    std::array<char, 41> public_key{};
    zmq_curve_public(public_key.data(), keys.secret.c_str());
    socket_.set(zmq::sockopt::curve_serverkey, keys.coupler);
    socket_.set(zmq::sockopt::curve_publickey, std::string(public_key.data()));
    socket_.set(zmq::sockopt::curve_secretkey, keys.secret);
  }

  void read_monitor() {
    int descriptor = -1;
    for (;;) {
      using Event = ConnectionMonitor::Event;
      const Event event = monitor_.next(descriptor);
      if (event == Event::none || event == Event::stopped) return;
      if (event == Event::turned_away) turned_away_ = true;
      if (event == Event::broken_off) ++broken_handshakes_;
      if (event == Event::opened || event == Event::closed) connected_ = event == Event::opened;
    }
  }

  bool take(Frame& frame) {
    const bool has_one_part = !message_.more();
    while (message_.more()) static_cast<void>(socket_.recv(message_, zmq::recv_flags::dontwait));
    if (!has_one_part) return false;
    broken_handshakes_ = 0;
    frame.content = {message_.data<std::byte>(), message_.size()};
    return true;
  }

  zmq::context_t context_;
  zmq::socket_t socket_;
  PatientReceiver receiver_;
  ConnectionMonitor monitor_;
  std::string path_;  ///< of an ipc address
  bool connected_ = false;
  bool turned_away_ = false;
  int broken_handshakes_ = 0;
  zmq::message_t message_;
};

constexpr int kRouterLingerMs = 1000;                     ///< for the last messages of a coupler that ends
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
    socket_.set(zmq::sockopt::router_mandatory, true);  // sending to an absent peer is an error, not a silent loss
    socket_.set(zmq::sockopt::router_handover, true);   // a peer that comes back keeps its name
    socket_.set(zmq::sockopt::sndtimeo, 0);             // a peer that reads nothing must not hold up the others
    try {
      const std::string address = with_numeric_host(endpoint);
      socket_.set(zmq::sockopt::ipv6, address.starts_with("tcp://["));
      socket_.bind(address);
      path_ = ipc_path(endpoint);
    } catch (const zmq::error_t& error) {
      if (is_storage_errno(error.num()) && error.num() != EIO)  // EIO: a file system without sockets
        throw StorageError("The socket " + endpoint + " cannot be made (" + error.what() +
                           "). Free space and inodes on that disk.");
      throw Refused("The address " + endpoint + " cannot be bound (" + error.what() +
                    "). Free it or choose another one.");
    }
  }
  ~ZeroMqRouter() override {  // components see that the run is over
    if (std::error_code ignored; std::filesystem::is_socket(path_, ignored)) ::unlink(path_.c_str());
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
    if (kind != std::filesystem::file_type::not_found && kind != std::filesystem::file_type::socket)
      throw Refused("The address " + endpoint +
                    " cannot be bound (there is a file of that name, not a socket). Choose another one.");
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

  std::string path_;  ///< of an ipc address
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

CouplerKeys read_coupler_keys(const std::string& path) {
  const Words lines = read_lines(path);
  CouplerKeys keys;
  keys.secret = take(lines, "secret", path);
  for (const char* role : {"fluid", "body"}) static_cast<void>(take(lines, role, path));
  for (const auto& [name, key] : lines)
    if (name != "secret") keys.admitted[take(lines, name, path)] = name;
  return keys;
}

ComponentKeys read_component_keys(const std::string& path) {
  const Words lines = read_lines(path);
  return {take(lines, "secret", path), take(lines, "coupler", path)};
}

std::unique_ptr<Dealer> connect_dealer(const std::string& endpoint, const std::string& name,
                                       const std::optional<ComponentKeys>& keys) {
  return std::make_unique<ZeroMqDealer>(endpoint, name, keys);
}

std::unique_ptr<Router> bind_router(const std::string& endpoint, const std::optional<CouplerKeys>& keys) {
  return std::make_unique<ZeroMqRouter>(endpoint, keys);
}

}  // namespace copepod::transport
