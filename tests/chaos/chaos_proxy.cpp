#include "chaos_proxy.hpp"

#include <chrono>
#include <filesystem>
#include <list>
#include <optional>
#include <vector>

#include <zmq.hpp>

namespace copepod::chaos {

namespace {

using Clock = std::chrono::steady_clock;
using Text = std::string;

enum class Direction { to_coupler, to_component };

struct Message {
  Text peer;
  Direction direction = Direction::to_coupler;
  Text bytes;
};

/// A message that passes later: at a time, or once another one has overtaken it.
struct Held {
  Message message;
  Clock::time_point due;
  bool until_overtaken = false;
};

zmq::socket_t quiet_socket(zmq::context_t& context, zmq::socket_type type) {
  zmq::socket_t socket(context, type);
  socket.set(zmq::sockopt::linger, 0);
  return socket;
}

}  // namespace

class ChaosProxy::Relay {
 public:
  Relay(const Text& coupler, const Text& folder, const Text& name, const ChaosPlan& plan)
      : coupler_(coupler), path_(folder + "/" + name + ".ipc"), fates_(plan) {
    listen();
  }

  [[nodiscard]] Text endpoint() const { return "ipc://" + path_; }
  [[nodiscard]] const std::map<Disturbance, std::int64_t>& counts() const { return counts_; }

  void run(const std::atomic<bool>& stopping) {
    while (!stopping.load()) {
      wait();
      while (auto message = from_component()) meet_fate(*message);
      for (auto& [peer, socket] : lanes_) {
        while (auto bytes = receive(socket)) meet_fate({peer, Direction::to_component, *bytes});
      }
      release(Clock::now());
    }
  }

 private:
  /// A broken connection comes back at another socket: the path is a link, so that binding the next socket
  /// and removing the last one do not meet.
  void listen() {
    const Text next = path_ + "." + std::to_string(generation_++);
    zmq::socket_t front = quiet_socket(context_, zmq::socket_type::router);
    front.set(zmq::sockopt::router_handover, true);
    front.bind("ipc://" + next);
    std::filesystem::create_symlink(next, path_ + ".link");
    std::filesystem::rename(path_ + ".link", path_);
    front_ = std::move(front);
  }

  zmq::socket_t make_lane(const Text& peer) {
    zmq::socket_t lane = quiet_socket(context_, zmq::socket_type::dealer);
    lane.set(zmq::sockopt::routing_id, peer);
    lane.connect(coupler_);
    return lane;
  }

  void cut() {
    held_.clear();
    listen();
    for (auto& [peer, lane] : lanes_) lane = make_lane(peer);
  }

  void wait() {
    std::vector<zmq::pollitem_t> items{{front_.handle(), 0, ZMQ_POLLIN, 0}};
    for (auto& [peer, lane] : lanes_) items.push_back({lane.handle(), 0, ZMQ_POLLIN, 0});
    auto until = Clock::now() + std::chrono::milliseconds(20);
    for (const Held& held : held_) until = std::min(until, held.due);
    zmq::poll(items,
              std::chrono::ceil<std::chrono::milliseconds>(std::max(until - Clock::now(), Clock::duration::zero())));
  }

  static std::optional<Text> receive(zmq::socket_t& socket) {
    zmq::message_t part;
    if (!socket.recv(part, zmq::recv_flags::dontwait)) return std::nullopt;
    return part.to_string();
  }

  std::optional<Message> from_component() {
    const auto peer = receive(front_);
    if (!peer) return std::nullopt;
    const Text bytes = receive(front_).value();
    if (!lanes_.contains(*peer)) lanes_.emplace(*peer, make_lane(*peer));
    return Message{*peer, Direction::to_coupler, bytes};
  }

  void pass(const Message& message) {
    if (message.direction == Direction::to_coupler) {
      lanes_.at(message.peer).send(zmq::buffer(message.bytes), zmq::send_flags::dontwait);
      return;
    }
    front_.send(zmq::buffer(message.peer), zmq::send_flags::sndmore);
    front_.send(zmq::buffer(message.bytes), zmq::send_flags::dontwait);
  }

  void pass_and_free_the_overtaken(const Message& message) {
    pass(message);
    for (Held& held : held_) {
      const bool overtaken =
          held.until_overtaken && held.message.peer == message.peer && held.message.direction == message.direction;
      if (overtaken) held.due = Clock::now();
    }
  }

  void hold(const Message& message, double seconds) {
    held_.push_back(
        {message, Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))});
  }

  void meet_fate(Message message) {
    const Disturbance fate = fates_.next();
    ++counts_[fate];
    switch (fate) {
      case Disturbance::none:
        return pass_and_free_the_overtaken(message);
      case Disturbance::drop:
        return;
      case Disturbance::repeat:
        pass(message);
        return pass(message);
      case Disturbance::replay:
        pass(message);
        return hold(message, 0.2 * fates_.uniform());
      case Disturbance::delay:
        return hold(message, 0.1 * fates_.uniform());
      case Disturbance::reorder:
        hold(message, 0.5);
        held_.back().until_overtaken = true;
        return;
      case Disturbance::truncate:
        message.bytes.resize(fates_.below(message.bytes.size()));
        return pass(message);
      case Disturbance::corrupt:
        message.bytes[fates_.below(message.bytes.size())] ^= static_cast<char>(1U << fates_.below(8));
        return pass(message);
      case Disturbance::cut:
        return cut();
    }
  }

  void release(Clock::time_point now) {
    for (auto held = held_.begin(); held != held_.end();) {
      if (held->due > now) {
        ++held;
        continue;
      }
      pass(held->message);
      held = held_.erase(held);
    }
  }

  Text coupler_, path_;
  Fates fates_;
  zmq::context_t context_;
  zmq::socket_t front_;
  std::map<Text, zmq::socket_t> lanes_;
  std::list<Held> held_;
  std::map<Disturbance, std::int64_t> counts_;
  int generation_ = 0;
};

ChaosProxy::ChaosProxy(const Text& coupler, const Text& folder, const Text& name, const ChaosPlan& plan)
    : relay_(std::make_unique<Relay>(coupler, folder, name, plan)), thread_([this] { relay_->run(stopping_); }) {}

ChaosProxy::~ChaosProxy() { stop(); }

Text ChaosProxy::endpoint() const { return relay_->endpoint(); }
const std::map<Disturbance, std::int64_t>& ChaosProxy::counts() const { return relay_->counts(); }

void ChaosProxy::stop() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace copepod::chaos
