#include "transport/keys.hpp"

#include <array>
#include <cstdint>
#include <fstream>
#include <sys/stat.h>

#include <zmq.hpp>

#include "contract/errors.hpp"

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

}  // namespace

CouplerKeys read_coupler_keys(const std::string& path) {
  const Words lines = read_lines(path);
  CouplerKeys keys;
  keys.secret = take(lines, "secret", path);
  for (const char* role : {"fluid", "body"}) keys.admitted[take(lines, role, path)] = role;
  return keys;
}

ComponentKeys read_component_keys(const std::string& path) {
  const Words lines = read_lines(path);
  return {take(lines, "secret", path), take(lines, "coupler", path)};
}

}  // namespace copepod::transport
