#include "transport/endpoint.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <netdb.h>
#include <sys/file.h>
#include <sys/un.h>
#include <unistd.h>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "system/durable_file.hpp"

namespace copepod::transport {

namespace {

constexpr std::string_view kIpc = "ipc://";
constexpr std::string_view kTcp = "tcp://";

void check_ipc(const std::string& endpoint) {
  const std::string path = endpoint.substr(kIpc.size());
  constexpr std::size_t longest = sizeof(sockaddr_un::sun_path) - 1;
  if (path.empty() || path.front() != '/')
    throw CaseError("The endpoint " + endpoint + " is not usable (its path is not absolute). Write ipc:///path.");
  if (path.size() > longest)
    throw CaseError("The endpoint " + endpoint + " is not usable (its path has " + std::to_string(path.size()) +
                    " bytes, sockets allow " + std::to_string(longest) + "). Use a shorter run directory.");
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
  const int number = number_in<int>(port).value_or(0);
  if (host.empty() || number <= 0 || number >= 65536)
    throw CaseError("The endpoint " + endpoint + " is not usable (no host or no port). Write tcp://host:port.");
  if (host == "*")
    throw CaseError("The endpoint " + endpoint +
                    " is not usable (components cannot connect to all interfaces). Name the address or host on which "
                    "the coupler listens.");
}

/// What the file holds: the process id of a coupler, living or dead, or nothing yet.
std::string owner_of(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t size = pread(descriptor, text.data(), text.size() - 1, 0);
  std::string owner(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  while (!owner.empty() && owner.back() == '\n') owner.pop_back();
  return owner;
}

bool is_process_id(const std::string& text) {
  return std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; }) && text.size() < 20;
}

[[noreturn]] void throw_full(const std::string& path, int error) {
  throw StorageError("The lock file " + path + " cannot be written (" + std::strerror(error) +
                     "). Free space and inodes on that disk.");
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
      getnameinfo(chosen->ai_addr, chosen->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) != 0)
    throw CaseError("The endpoint " + endpoint + " is not usable (" + host + ": " + gai_strerror(error) +
                    "). Write an address, or a name that this machine resolves.");
  const std::string numeric = text.data();
  return std::string(kTcp) + (chosen->ai_family == AF_INET6 ? "[" + numeric + "]" : numeric) + ":" + port;
}

void require_keys_off_this_machine(const std::string& endpoint, bool has_keys) {
  if (has_keys || stays_on_this_machine(endpoint)) return;
  throw CaseError("The endpoint " + endpoint +
                  " needs keys (other machines could listen and take part). Give --keys, or let deploy/copepod start "
                  "the run: it makes them.");
}

std::string ipc_path(const std::string& endpoint) {
  return endpoint.starts_with(kIpc) ? endpoint.substr(kIpc.size()) : std::string{};
}

void check_endpoint(const std::string& endpoint) {
  if (endpoint.starts_with(kIpc)) return check_ipc(endpoint);
  if (endpoint.starts_with(kTcp)) return check_tcp(endpoint);
  throw CaseError("The endpoint '" + endpoint +
                  "' is not usable (neither ipc:// nor tcp://). Write ipc:///path or tcp://host:port.");
}

LockFile::LockFile(const std::string& path) : descriptor_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
  if (descriptor_ < 0) {
    if (is_storage_errno(errno)) throw_full(path, errno);
    throw Refused("The lock file " + path + " cannot be opened (" + std::strerror(errno) + "). " +
                  remedy_for(errno, "Choose a directory that exists and that you may write."));
  }
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    const std::string owner = owner_of(descriptor_);
    close(descriptor_);
    throw Refused("The address is taken (the coupler with process id " + (owner.empty() ? "unknown" : owner) +
                  " holds " + path + "). Wait for it to end, or use another run directory.");
  }
  if (!is_process_id(owner_of(descriptor_))) {
    close(descriptor_);
    throw Refused("The lock file " + path + " cannot be used (it was not written by a coupler). Use another address.");
  }
  const std::string pid = std::to_string(getpid()) + "\n";
  const bool written = ftruncate(descriptor_, 0) == 0 &&
                       pwrite(descriptor_, pid.data(), pid.size(), 0) == static_cast<ssize_t>(pid.size());
  if (!written) {
    const int error = errno;
    close(descriptor_);
    throw_full(path, error);
  }
}

// The file stays: removing it would let a third process lock a new file of the same name beside a second one
// that waits on the old.
LockFile::~LockFile() { close(descriptor_); }

}  // namespace copepod::transport
