#include "files/stateless_checkpoint.hpp"

#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <span>
#include <unistd.h>

#include "contract/errors.hpp"
#include "system/write_all.hpp"

namespace copepod::fluid {

namespace {

std::string checkpoint_text(const std::string& solver) { return "copepod " + solver + " checkpoint 1\n"; }

}  // namespace

void save_stateless(const std::string& path, const std::string& solver) {
  const std::string text = checkpoint_text(solver);
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  const bool written = file >= 0 && write_all(file, std::as_bytes(std::span(text)));
  const bool synced = written && fsync(file) == 0;
  const bool closed = file >= 0 && close(file) == 0;
  if (!synced || !closed)
    throw StorageError("checkpoint " + path +
                       " cannot be written (disk full or no permission). Make room and resume.");
}

void restore_stateless(const std::string& path, const std::string& solver) {
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text != checkpoint_text(solver))
    throw StorageError("checkpoint " + path + " is not one of a " + solver +
                       " fluid (missing, damaged or of another solver). Use an earlier checkpoint.");
}

}  // namespace copepod::fluid
