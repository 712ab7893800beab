#include <zmq.hpp>

#include "contract/errors.hpp"
#include "transport/connection_monitor.hpp"
#include "transport/endpoint.hpp"
#include "transport/zeromq.hpp"

namespace copepod::transport {

namespace {

constexpr int kLingerMs = 500;  ///< for the last message of a component that ends
constexpr int kReconnectMs = 100;
constexpr std::int64_t kLargestMessage = 256LL << 20;  ///< bytes

class ZeroMqDealer final : public Dealer {
 public:
  ZeroMqDealer(const std::string& endpoint, const std::string& name, WaitPolicy policy)
      : policy_(policy),
        context_(1),
        socket_(context_, zmq::socket_type::dealer),
        monitor_(context_, socket_, "dealer-monitor") {
    check_endpoint(endpoint);
    socket_.set(zmq::sockopt::linger, kLingerMs);
    socket_.set(zmq::sockopt::maxmsgsize, kLargestMessage);
    socket_.set(zmq::sockopt::routing_id, name);
    socket_.set(zmq::sockopt::reconnect_ivl, kReconnectMs);
    socket_.set(zmq::sockopt::sndtimeo, 1000);
    try {
      socket_.connect(endpoint);
    } catch (const zmq::error_t& error) {
      throw CaseError("The endpoint " + endpoint + " cannot be connected to (" + error.what() +
                      "). Use the address that the coupler was given.");
    }
  }

  bool receive(Frame& frame, Duration wait) override {
    if (try_for_a_while(policy_, wait, [&] { return receive_now(frame); })) return true;
    zmq::pollitem_t items[] = {{socket_.handle(), 0, ZMQ_POLLIN, 0}};
    try {
      zmq::poll(items, 1, std::chrono::duration_cast<std::chrono::milliseconds>(wait));
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
    }
    return receive_now(frame);
  }

  bool send(Bytes bytes) override {
    return socket_.send(zmq::const_buffer(bytes.data(), bytes.size()), zmq::send_flags::none).has_value();
  }

  bool connected() override {
    int descriptor = -1;
    for (;;) {
      switch (monitor_.next(descriptor)) {
        case ConnectionMonitor::Event::none:
          return connected_;
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

 private:
  bool receive_now(Frame& frame) {
    if (!socket_.recv(message_, zmq::recv_flags::dontwait)) return false;
    const bool has_one_part = !message_.more();
    while (message_.more()) static_cast<void>(socket_.recv(message_, zmq::recv_flags::dontwait));
    if (!has_one_part) return false;
    fill(frame, message_.data(), message_.size());
    return true;
  }

  WaitPolicy policy_;
  zmq::context_t context_;
  zmq::socket_t socket_;
  ConnectionMonitor monitor_;
  bool connected_ = false;
  zmq::message_t message_;
};

}  // namespace

std::unique_ptr<Dealer> connect_dealer(const std::string& endpoint, const std::string& name,
                                       WaitPolicy policy) {
  return std::make_unique<ZeroMqDealer>(endpoint, name, policy);
}

}  // namespace copepod::transport
