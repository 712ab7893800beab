#include "storage/checksum.hpp"

#include <algorithm>
#include <fstream>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "contract/errors.hpp"

namespace copepod::coupler {

struct Checksum::State {
  XXH3_state_t hash;
};

Checksum::Checksum() : state_(new State, [](State* state) { delete state; }) { XXH3_64bits_reset(&state_->hash); }

void Checksum::add(std::string_view bytes) { XXH3_64bits_update(&state_->hash, bytes.data(), bytes.size()); }

std::uint64_t Checksum::value() const { return XXH3_64bits_digest(&state_->hash); }

Checksum checksum_of_start(const std::filesystem::path& file, std::uint64_t bytes, std::uint64_t skipped) {
  constexpr std::uint64_t piece_bytes = std::uint64_t{1} << 20;
  Checksum checksum;
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(skipped));
  std::vector<char> piece(piece_bytes);
  while (bytes > 0) {
    const auto size = static_cast<std::streamsize>(std::min(bytes, piece_bytes));
    if (!stream.read(piece.data(), size))
      throw StorageError(file.string() + " cannot be read (missing, too short or a bad disk). Use another checkpoint.");
    checksum.add({piece.data(), static_cast<std::size_t>(size)});
    bytes -= static_cast<std::uint64_t>(size);
  }
  return checksum;
}

}  // namespace copepod::coupler
