#include "transport/authenticator.hpp"

#include <array>

namespace copepod::transport {

namespace {

/// Frames of a request: version, id, domain, address, routing id, mechanism, then credentials [RFC 27].
enum Place : std::size_t { version = 0, request_id = 1, address = 3, mechanism = 5, credential = 6, count = 7 };

std::string as_bytes(const std::string& z85_key) {
  std::array<std::uint8_t, 32> bytes{};
  zmq_z85_decode(bytes.data(), z85_key.c_str());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

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

}  // namespace copepod::transport
