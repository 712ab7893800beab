#include "transport/endpoint.hpp"

#include <arpa/inet.h>
#include <array>
#include <charconv>
#include <memory>
#include <netdb.h>
#include <sys/un.h>

#include "contract/errors.hpp"

namespace copepod::transport {

namespace {

constexpr std::string_view kIpc = "ipc://";
constexpr std::string_view kTcp = "tcp://";

void check_ipc(const std::string& endpoint) {
  const std::string path = endpoint.substr(kIpc.size());
  constexpr std::size_t longest = sizeof(sockaddr_un::sun_path) - 1;
  if (path.empty() || path.front() != '/') {
    throw CaseError("The endpoint " + endpoint + " is not usable (its path is not absolute). Write ipc:///path.");
  }
  if (path.size() > longest) {
    throw CaseError("The endpoint " + endpoint + " is not usable (its path has " + std::to_string(path.size()) +
                    " bytes, sockets allow " + std::to_string(longest) + "). Use a shorter run directory.");
  }
}

/// The host of a tcp endpoint, without the brackets around an IPv6 address, and its port.
struct TcpAddress {
  std::string host;
  std::string port;
};

TcpAddress tcp_address(const std::string& endpoint) {
  const std::size_t colon = endpoint.rfind(':');
  if (colon < kTcp.size()) return {};
  std::string host = endpoint.substr(kTcp.size(), colon - kTcp.size());
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return {std::move(host), endpoint.substr(colon + 1)};
}

void check_tcp(const std::string& endpoint) {
  const auto [host, port] = tcp_address(endpoint);
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  const bool is_port = error == std::errc{} && end == port.data() + port.size() && number > 0 && number < 65536;
  if (host.empty() || !is_port) {
    throw CaseError("The endpoint " + endpoint + " is not usable (no host or no port). Write tcp://host:port.");
  }
  if (host == "*") {
    throw CaseError("The endpoint " + endpoint +
                    " is not usable (components cannot connect to all interfaces). Name the address or host on which "
                    "the coupler listens.");
  }
}

}  // namespace

bool stays_on_this_machine(const std::string& endpoint) {
  if (endpoint.starts_with(kIpc)) return true;
  const std::string host = tcp_address(endpoint).host;
  in_addr address{};
  const bool is_ipv4 = inet_pton(AF_INET, host.c_str(), &address) == 1;
  return host == "localhost" || host == "::1" || (is_ipv4 && ntohl(address.s_addr) >> 24U == IN_LOOPBACKNET);
}

std::string with_numeric_host(const std::string& endpoint) {
  if (!endpoint.starts_with(kTcp)) return endpoint;
  const auto [host, port] = tcp_address(endpoint);
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* first = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &wanted, &first);
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> found(first, &freeaddrinfo);
  const addrinfo* chosen = first;
  while (chosen != nullptr && chosen->ai_family != AF_INET) chosen = chosen->ai_next;
  if (chosen == nullptr) chosen = first;
  std::array<char, NI_MAXHOST> text{};
  if (error != 0 ||
      getnameinfo(chosen->ai_addr, chosen->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) != 0) {
    throw CaseError("The endpoint " + endpoint + " is not usable (" + host + ": " + gai_strerror(error) +
                    "). Write an address, or a name that this machine resolves.");
  }
  const std::string numeric = text.data();
  return std::string(kTcp) + (chosen->ai_family == AF_INET6 ? "[" + numeric + "]" : numeric) + ":" + port;
}

void require_keys_off_this_machine(const std::string& endpoint, bool has_keys) {
  if (has_keys || stays_on_this_machine(endpoint)) return;
  throw CaseError("The endpoint " + endpoint +
                  " needs keys (other machines could listen and take part). Give --keys, or let deploy/copepod "
                  "start the run: it makes them.");
}

std::string ipc_path(const std::string& endpoint) {
  return endpoint.starts_with(kIpc) ? endpoint.substr(kIpc.size()) : std::string{};
}

void check_endpoint(const std::string& endpoint) {
  if (endpoint.starts_with(kIpc)) return check_ipc(endpoint);
  if (endpoint.starts_with(kTcp)) return check_tcp(endpoint);
  throw CaseError("The endpoint '" + endpoint +
                  "' is not usable (neither ipc:// nor tcp://). Write ipc:///path or "
                  "tcp://host:port.");
}

}  // namespace copepod::transport
