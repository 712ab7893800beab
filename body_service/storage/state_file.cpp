#include "storage/state_file.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>

#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "system/durable_file.hpp"

namespace copepod::body {

namespace {

static_assert(std::endian::native == std::endian::little, "state files are little-endian");

using Words = std::vector<std::uint64_t>;

constexpr std::uint64_t magic = 0x59444f4245504f43ULL;  // "COPEBODY"
constexpr std::uint64_t version = 4;
constexpr std::size_t header_words = 6;
constexpr std::size_t words_per_body = 13;
constexpr std::uint64_t most_memory_per_body = 10'000;  // words
constexpr std::size_t piece_bytes = 1 << 20;            ///< read between two progress reports

[[noreturn]] void fail(const std::string& path, const std::string& problem, const std::string& remedy) {
  throw StorageError("body state '" + path + "' " + problem + ". " + remedy);
}

std::uint64_t digest_of_words(std::span<const std::uint64_t> words) {
  Digest digest;
  digest.add_all(words);
  return digest.value();
}

/// Fills zeroed `words` from a file and shortens them to its length; a last word that is cut off is kept,
/// padded with zeros.
void read_all(std::istream& file, Words& words, const std::function<void()>& on_piece) {
  const auto bytes = std::as_writable_bytes(std::span(words));
  std::size_t done = 0;
  while (file && done < bytes.size()) {
    const std::size_t piece = std::min(bytes.size() - done, piece_bytes);
    file.read(reinterpret_cast<char*>(bytes.data() + done), piece);
    done += static_cast<std::size_t>(file.gcount());
    if (on_piece) on_piece();
  }
  words.resize((done + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t));
}

}  // namespace

std::uint64_t layout_digest(const BodySetup& setup) {
  BodySetup layout;
  layout.step_s = setup.step_s;
  layout.integrator = setup.integrator;
  for (const BodySpecification& body : setup.bodies) {
    BodySpecification& kept = layout.bodies.emplace_back();
    kept.name = body.name;
    kept.shape = body.shape;
    kept.motion = body.motion;
  }
  return digest_of(conversion::to_bytes(layout));
}

std::uint64_t state_digest(std::int64_t step, const MotionState& state, const std::vector<std::uint64_t>& memory) {
  Digest digest;
  digest.add(static_cast<std::uint64_t>(step));
  for_each_part([&](const auto& numbers) { digest.add_all(numbers); }, state);
  digest.add_all(memory);
  return digest.value();
}

void write_state(const std::string& path, std::uint64_t layout_digest, std::int64_t step, const MotionState& state,
                 const std::function<void()>& on_piece, const std::vector<std::uint64_t>& memory) {
  const auto bodies = static_cast<std::size_t>(state.bodies());
  Words words{magic, version, layout_digest, static_cast<std::uint64_t>(step), bodies, memory.size()};
  words.reserve(header_words + words_per_body * bodies + memory.size() + 1);
  const auto append = [&](const auto& numbers) {
    for (const double number : numbers.reshaped()) words.push_back(std::bit_cast<std::uint64_t>(number));
  };
  for_each_part(append, state);
  words.insert(words.end(), memory.begin(), memory.end());
  words.push_back(digest_of_words(words));

  write_durably(path, std::as_bytes(std::span(words)), on_piece);
}

std::int64_t read_state(const std::string& path, std::uint64_t layout_digest, MotionState& state,
                        const std::function<void()>& on_piece, std::vector<std::uint64_t>* memory) {
  const std::string remedy = "Resume from another checkpoint.";
  const auto bodies = static_cast<std::size_t>(state.bodies());

  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "could not be opened (" + std::string(std::strerror(errno)) + ")", remedy);
  Words words(header_words);
  read_all(file, words, on_piece);

  if (words.size() < header_words || words[0] != magic) fail(path, "is not a saved body state", remedy);
  if (words[1] != version)
    fail(path, "has format version " + std::to_string(words[1]) + " (this program reads version 4)",
         "Resume with the program that wrote it.");
  if (words[2] != layout_digest || words[4] != bodies)
    fail(path, "belongs to another case (bodies, their shapes, the step or the integrator differ)",
         "Resume with the case file that wrote it.");
  const std::uint64_t held = words[5];
  if (held > (memory == nullptr ? 0 : most_memory_per_body * bodies)) fail(path, "holds too much memory", remedy);
  const std::size_t expected = header_words + words_per_body * bodies + held + 1;
  Words rest(expected - header_words + 1);  // one more than fits, to notice a file that is too long
  read_all(file, rest, on_piece);
  words.insert(words.end(), rest.begin(), rest.end());
  const auto content = std::span<const std::uint64_t>(words);
  if (words.size() != expected || content.back() != digest_of_words(content.first(expected - 1)))
    fail(path, "is damaged (wrong length or checksum)", remedy);
  auto numbers = content.subspan(header_words);
  const auto take = [&](auto& array) {
    for (double& number : array.reshaped()) {
      number = std::bit_cast<double>(numbers.front());
      numbers = numbers.subspan(1);
    }
  };
  for_each_part(take, state);
  if (memory != nullptr) memory->assign(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(held));
  return static_cast<std::int64_t>(words[3]);
}

}  // namespace copepod::body
