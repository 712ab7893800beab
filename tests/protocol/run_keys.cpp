#include "run_keys.hpp"

#include <array>
#include <filesystem>
#include <fstream>

#include <zmq.hpp>

namespace copepod::protocol_test {

RunKeys::RunKeys() {
  for (const char* role : {"coupler", "fluid", "body"}) {
    std::array<char, 41> known{}, secret{};
    zmq_curve_keypair(known.data(), secret.data());
    public_[role] = known.data();
    secret_[role] = secret.data();
  }
  write("coupler", {"fluid", "body"});
  write("fluid", {"coupler"});
  write("body", {"coupler"});
}

void RunKeys::write(const std::string& role, const std::vector<std::string>& peers) const {
  std::ofstream file(file_of(role));
  file << "secret " << secret_of(role) << "\n";
  for (const std::string& peer : peers) file << peer << " " << public_of(peer) << "\n";
  std::filesystem::permissions(file_of(role), std::filesystem::perms::owner_read);
}

}  // namespace copepod::protocol_test
