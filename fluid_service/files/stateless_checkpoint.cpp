#include "files/stateless_checkpoint.hpp"

#include <fstream>
#include <iterator>

#include "contract/errors.hpp"
#include "system/durable_file.hpp"

namespace copepod::fluid {

namespace {

std::string checkpoint_text(const std::string& solver) { return "copepod " + solver + " checkpoint 1\n"; }

}  // namespace

void save_stateless(const std::string& path, const std::string& solver) {
  write_durably(path, checkpoint_text(solver));
}

void restore_stateless(const std::string& path, const std::string& solver) {
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text != checkpoint_text(solver))
    throw StorageError("checkpoint " + path + " is not one of a " + solver +
                       " fluid (missing, damaged or of another solver). Use an earlier checkpoint.");
}

}  // namespace copepod::fluid
