// Fuzz target: the files of a checkpoint. Byte 0 selects the file that the rest is, and whether its checksum
// is corrected.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <span>
#include <string>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

#include <nlohmann/json.hpp>

#include "checkpoint/checkpoint_store.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "storage/state_file.hpp"
#include "temporary_folder.hpp"

namespace {

using namespace copepod;
using Bytes = std::span<const std::uint8_t>;

constexpr std::uint64_t kCaseDigest = 42;
constexpr Eigen::Index kBodies = 2;

/// A file in memory that has a path.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("checkpoint", MFD_CLOEXEC)) {}
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(descriptor_); }

  void fill(Bytes bytes) const {
    const bool filled = ftruncate(descriptor_, 0) == 0 &&
                        pwrite(descriptor_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size());
    if (!filled) std::abort();
  }
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

/// The last word becomes the digest of those before, so that what is behind the checksum is reached too.
std::vector<std::uint8_t> with_digest(Bytes bytes) {
  std::vector<std::uint8_t> result(bytes.begin(), bytes.end());
  if (result.size() < sizeof(std::uint64_t)) return result;
  result.resize(result.size() / sizeof(std::uint64_t) * sizeof(std::uint64_t));
  Digest digest;
  for (std::size_t i = 0; i + sizeof(std::uint64_t) < result.size(); i += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, &result[i], sizeof word);
    digest.add(word);
  }
  const std::uint64_t sum = digest.value();
  std::memcpy(&result[result.size() - sizeof sum], &sum, sizeof sum);
  return result;
}

void read_bodies(Bytes bytes) {
  static const MemoryFile file;
  file.fill(bytes);
  body::MotionState state;
  state.resize(kBodies);
  static_cast<void>(body::read_state(file.path(), kCaseDigest, state));
}

/// What was read is written again and reads the same.
void read_coupler(Bytes bytes) {
  using nlohmann::ordered_json;
  const auto state = coupler::coupler_state_from_json(ordered_json::parse(bytes.begin(), bytes.end(), nullptr, false));
  const std::string once = coupler::to_json(state).dump();
  if (coupler::to_json(coupler::coupler_state_from_json(ordered_json::parse(once))).dump() != once) std::abort();
}

void read_manifest(Bytes bytes) {
  static const TemporaryFolder folder("/dev/shm");  // in memory
  std::ofstream(folder.path("manifest.json"), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  static_cast<void>(coupler::find_damage(folder.path(), "42"));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const Bytes content(bytes + 1, size - 1);
  try {
    switch (bytes[0]) {
      case 'b':
        read_bodies(content);
        break;
      case 's':
        read_bodies(with_digest(content));
        break;
      case 'c':
        read_coupler(content);
        break;
      case 'm':
        read_manifest(content);
        break;
      default:
        break;
    }
  } catch (const StorageError&) {
  }
  return 0;
}
