#pragma once

#include <map>
#include <string>
#include <vector>

#include "temporary_folder.hpp"

namespace copepod::protocol_test {

/// Keys of a run and their files, as the deploy command makes them.
class RunKeys {
 public:
  RunKeys();

  [[nodiscard]] std::string file_of(const std::string& role) const { return folder_.path(role + ".key"); }
  [[nodiscard]] std::vector<std::string> option_of(const std::string& role) const { return {"--keys", file_of(role)}; }
  [[nodiscard]] const std::string& public_of(const std::string& role) const { return public_.at(role); }
  [[nodiscard]] const std::string& secret_of(const std::string& role) const { return secret_.at(role); }

 private:
  void write(const std::string& role, const std::vector<std::string>& peers) const;

  TemporaryFolder folder_;
  std::map<std::string, std::string> public_, secret_;
};

}  // namespace copepod::protocol_test
