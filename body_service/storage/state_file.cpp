#include "storage/state_file.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <span>
#include <unistd.h>
#include <vector>

#include "component/progress.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "system/write_all.hpp"

namespace copepod::body {

namespace {

static_assert(std::endian::native == std::endian::little, "state files are little-endian");

using Words = std::vector<std::uint64_t>;

constexpr std::uint64_t magic = 0x59444f4245504f43ULL;  // "COPEBODY"
constexpr std::uint64_t version = 1;
constexpr std::size_t header_words = 5;
constexpr std::size_t words_per_body = 13;
constexpr std::size_t piece_bytes = 1 << 20;  ///< at most so much between two signs of progress

[[noreturn]] void fail(const std::string& path, const std::string& problem, const std::string& remedy) {
  throw StorageError("body state '" + path + "' " + problem + ". " + remedy);
}

[[noreturn]] void fail_with_errno(const std::string& path, const std::string& verb,
                                  const std::string& remedy) {
  fail(path, "could not be " + verb + " (" + std::strerror(errno) + ")", remedy);
}

/// A file descriptor that closes itself.
class File {
 public:
  File(const std::string& path, int flags) : descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] bool open() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

std::uint64_t digest_of(std::span<const std::uint64_t> words) {
  Digest digest;
  for (const std::uint64_t word : words) digest.add(word);
  return digest.value();
}

template <typename Matrix>
void append(Words& words, const Matrix& numbers) {
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    words.push_back(std::bit_cast<std::uint64_t>(numbers.data()[i]));
  }
}

template <typename Matrix>
void take(std::span<const std::uint64_t>& words, Matrix& numbers) {
  for (Eigen::Index i = 0; i < numbers.size(); ++i) numbers.data()[i] = std::bit_cast<double>(words[i]);
  words = words.subspan(static_cast<std::size_t>(numbers.size()));
}

bool write_pieces(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t piece = std::min(bytes.size(), piece_bytes);
    if (!write_all(descriptor, bytes.first(piece))) return false;
    report_progress();
    bytes = bytes.subspan(piece);
  }
  return true;
}

/// Fills zeroed `words` from a file and shortens it to what was there; a last word that is cut off counts,
/// filled up with zeros.
/// @return false if reading failed
bool read_all(int descriptor, Words& words) {
  auto bytes = std::as_writable_bytes(std::span(words));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(descriptor, bytes.data() + done, std::min(bytes.size() - done, piece_bytes));
    report_progress();
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  words.resize((done + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t));
  return true;
}

}  // namespace

void write_state(const std::string& path, const StateLabel& label, const MotionState& state) {
  const auto bodies = static_cast<std::size_t>(state.bodies());
  Words words{magic, version, label.case_digest, static_cast<std::uint64_t>(label.step), bodies};
  words.reserve(header_words + words_per_body * bodies + 1);
  append(words, state.position_m);
  append(words, state.orientation_wxyz);
  append(words, state.velocity_m_per_s);
  append(words, state.angular_momentum_N_m_s);
  words.push_back(digest_of(words));

  const std::string remedy = "Check that the folder exists, is writable and has room.";
  const std::string unfinished = path + ".unfinished";
  const File file(unfinished, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.open()) fail_with_errno(path, "created", remedy);
  if (!write_pieces(file.descriptor(), std::as_bytes(std::span(words))) || ::fsync(file.descriptor()) != 0) {
    const int error = errno;
    ::unlink(unfinished.c_str());
    errno = error;
    fail_with_errno(path, "written", remedy);
  }
  if (::rename(unfinished.c_str(), path.c_str()) != 0) fail_with_errno(path, "renamed", remedy);
  // The name is an entry of the folder, which has to reach the disk as well.
  const auto folder = std::filesystem::absolute(path).parent_path();
  const File directory(folder.string(), O_RDONLY | O_DIRECTORY);
  if (!directory.open() || ::fsync(directory.descriptor()) != 0) fail_with_errno(path, "synced", remedy);
}

std::int64_t read_state(const std::string& path, std::uint64_t case_digest, MotionState& state) {
  const std::string remedy = "Resume from another checkpoint.";
  const auto bodies = static_cast<std::size_t>(state.bodies());
  const std::size_t expected = header_words + words_per_body * bodies + 1;

  const File file(path, O_RDONLY);
  if (!file.open()) fail_with_errno(path, "opened", remedy);
  Words words(expected + 1);  // one more than fits, to notice a file that is too long
  if (!read_all(file.descriptor(), words)) fail_with_errno(path, "read", remedy);

  if (words.size() < header_words || words[0] != magic) fail(path, "is no saved body state", remedy);
  if (words[1] != version) {
    fail(path, "has format version " + std::to_string(words[1]) + " (this program reads version 1)",
         "Resume with the program that wrote it.");
  }
  if (words[2] != case_digest || words[4] != bodies) {
    fail(path, "belongs to another case (bodies, springs, step or integrator differ)",
         "Resume with the case file that wrote it.");
  }
  const auto content = std::span<const std::uint64_t>(words);
  if (words.size() != expected || content.back() != digest_of(content.first(expected - 1))) {
    fail(path, "is damaged (length or checksum do not fit)", remedy);
  }
  auto numbers = content.subspan(header_words);
  take(numbers, state.position_m);
  take(numbers, state.orientation_wxyz);
  take(numbers, state.velocity_m_per_s);
  take(numbers, state.angular_momentum_N_m_s);
  return static_cast<std::int64_t>(words[3]);
}

}  // namespace copepod::body
