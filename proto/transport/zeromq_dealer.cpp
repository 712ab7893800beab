#include <array>

#include <zmq.hpp>

#include "contract/errors.hpp"
#include "transport/connection_monitor.hpp"
#include "transport/endpoint.hpp"
#include "transport/patient_receiver.hpp"
#include "transport/zeromq.hpp"

namespace copepod::transport {

namespace {

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
      switch (monitor_.next(descriptor)) {
        case ConnectionMonitor::Event::none:
        case ConnectionMonitor::Event::stopped:
          return;
        case ConnectionMonitor::Event::turned_away:
          turned_away_ = true;
          break;
        case ConnectionMonitor::Event::broken_off:
          ++broken_handshakes_;
          break;
        case ConnectionMonitor::Event::opened:
          connected_ = true;
          break;
        case ConnectionMonitor::Event::closed:
          connected_ = false;
          break;
        case ConnectionMonitor::Event::other:
          break;
      }
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
  bool connected_ = false;
  bool turned_away_ = false;
  int broken_handshakes_ = 0;
  zmq::message_t message_;
};

}  // namespace

std::unique_ptr<Dealer> connect_dealer(const std::string& endpoint, const std::string& name,
                                       const std::optional<ComponentKeys>& keys) {
  return std::make_unique<ZeroMqDealer>(endpoint, name, keys);
}

}  // namespace copepod::transport
