#include "contract/controller.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "system/durable_file.hpp"

namespace copepod {

namespace {

std::string with_digest(const std::string& state) { return std::to_string(digest_of(state)) + "\n" + state; }

}  // namespace

void Controller::save(const std::string& path) { write_durably(path, with_digest(state())); }

void Controller::restore(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  const std::string state = content.substr(std::min(content.size(), content.find('\n') + 1));
  if (!file || content != with_digest(state))
    throw StorageError(path +
                       " is not the state of a controller (missing or damaged). Resume from another checkpoint.");
  set_state(state);
}

}  // namespace copepod
