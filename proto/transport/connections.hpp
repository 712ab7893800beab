#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <zmq.hpp>

namespace copepod::transport {

/// Reports what happens to the connections of a socket, which ZeroMQ sends to a second, inner socket. A
/// handshake fails for good (turned_away) if a key is refused or only one side has keys; it is broken off,
/// and tried again, if the peer cannot read it or ends.
class ConnectionMonitor {
 public:
  enum class Event { none, opened, closed, turned_away, broken_off, other, stopped };

  /// @param name  unique in the context
  /// @param wait  of next(), at most
  ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched, const std::string& name,
                    std::chrono::milliseconds wait = {});
  ~ConnectionMonitor() { stop(); }

  /// Ends it, and a wait of another thread in next(); by the thread that uses the watched socket, before that closes.
  void stop() { zmq_socket_monitor(watched_.handle(), nullptr, 0); }

  /// The next event; none if there was none in time, stopped after stop().
  /// @param descriptor  of the connection it is about
  Event next(int& descriptor);

 private:
  zmq::socket_t& watched_;
  zmq::socket_t socket_;
};

/// Decides which peers may connect to a socket with CURVE, by answering ZeroMQ's authentication requests
/// (ZAP, RFC 27): the holder of an admitted key connects under the name that belongs to it, all others are
/// rejected. Used by the thread of the socket, between two waits; exists before the socket is bound.
class Authenticator {
 public:
  /// @param admitted  public key (Z85) to name; every message carries the name of its sender ("User-Id")
  Authenticator(zmq::context_t& context, const std::map<std::string, std::string>& admitted);

  /// Answers all requests that have arrived.
  /// @return addresses of those who were rejected
  std::vector<std::string> answer();

 private:
  zmq::socket_t socket_;
  std::map<std::string, std::string> admitted_;  ///< public key as bytes
};

/// The connections of a router's socket, followed by a thread of its own: however busy or quiet the run is, those of
/// strangers must not take all descriptors of the process. Of more than kMost connections it closes one on which no
/// message has come, the oldest first; then the one that has been silent for longest.
class Connections {
 public:
  static constexpr std::size_t kMost = 64;         ///< a run needs four
  static constexpr std::size_t kMostRemarks = 64;  ///< that wait to be read

  /// @param context  of `watched`
  Connections(zmq::context_t& context, zmq::socket_t& watched);
  ~Connections();

  /// A message of this peer came over the connection with this file descriptor.
  void spoke(const std::string& peer, int descriptor);

  /// Whether the connection over which the peer spoke last still stands. The thread may learn of it after the message.
  [[nodiscard]] bool connected(const std::string& peer);

  void remark(std::string text);
  /// The next remark about a stranger; empty if there is none.
  std::string next_remark();

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection {
    Clock::time_point opened;
    std::uint64_t heard = 0;  ///< when the last message came, counted in messages; 0: none yet
    bool is_stalled = false;  ///< and that has been remarked
  };

  void watch();
  void opened(int descriptor);
  void closed(int descriptor);
  void close_one();
  void note_stalled();
  void keep(std::string remark) {
    if (remarks_.size() < kMostRemarks) remarks_.push_back(std::move(remark));
  }

  ConnectionMonitor monitor_;
  std::mutex mutex_;                    ///< of what follows
  std::map<int, Connection> standing_;  ///< by file descriptor
  std::map<std::string, int> last_;     ///< connection on which each peer spoke last
  std::uint64_t messages_ = 0;
  std::deque<std::string> remarks_;
  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

}  // namespace copepod::transport
