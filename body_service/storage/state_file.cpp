#include "storage/state_file.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>
#include <vector>

#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "system/durable_file.hpp"

namespace copepod::body {

namespace {

static_assert(std::endian::native == std::endian::little, "state files are little-endian");

using Words = std::vector<std::uint64_t>;

constexpr std::uint64_t magic = 0x59444f4245504f43ULL;  // "COPEBODY"
constexpr std::uint64_t version = 1;
constexpr std::size_t header_words = 5;
constexpr std::size_t words_per_body = 13;
constexpr std::size_t piece_bytes = 1 << 20;  ///< read between two progress reports

template <typename Matrix>
void add_numbers(Digest& digest, const Matrix& numbers) {
  for (Eigen::Index i = 0; i < numbers.size(); ++i) digest.add(numbers.data()[i]);
}

void add_text(Digest& digest, const std::string& text) {
  digest.add(std::uint64_t{text.size()});
  for (const char c : text) digest.add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
}

[[noreturn]] void fail(const std::string& path, const std::string& problem, const std::string& remedy) {
  throw StorageError("body state '" + path + "' " + problem + ". " + remedy);
}

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

/// Fills zeroed `words` from a file and shortens them to its length; a last word that is cut off is kept,
/// padded with zeros.
void read_all(std::istream& file, Words& words, const std::function<void()>& on_piece) {
  const auto bytes = std::as_writable_bytes(std::span(words));
  std::size_t done = 0;
  while (file && done < bytes.size()) {
    const std::size_t piece = std::min(bytes.size() - done, piece_bytes);
    file.read(reinterpret_cast<char*>(bytes.data() + done), static_cast<std::streamsize>(piece));
    done += static_cast<std::size_t>(file.gcount());
    if (on_piece) on_piece();
  }
  words.resize((done + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t));
}

}  // namespace

std::uint64_t case_digest(const BodySetup& setup) {
  Digest digest;
  digest.add(setup.step_s);
  digest.add(static_cast<std::uint64_t>(setup.integrator));
  add_numbers(digest, setup.gravity_m_per_s2);
  digest.add(setup.fluid_density_kg_per_m3);
  digest.add(std::uint64_t{setup.bodies.size()});
  for (const auto& body : setup.bodies) {
    add_text(digest, body.name);
    digest.add(static_cast<std::uint64_t>(body.shape.kind));
    digest.add(body.shape.radius_m);
    digest.add(body.shape.length_m);
    digest.add(body.mass_kg);
    digest.add(static_cast<std::uint64_t>(body.motion));
    if (body.motion == MotionKind::axis) add_numbers(digest, body.axis);
  }
  for (const auto& spring : setup.springs) {
    digest.add(static_cast<std::uint64_t>(spring.body_A));
    digest.add(static_cast<std::uint64_t>(spring.body_B));
    digest.add(spring.stiffness_N_per_m);
    digest.add(spring.damping_N_s_per_m);
    digest.add(spring.rest_length_m);
    add_numbers(digest, spring.anchor_A_m);
    add_numbers(digest, spring.anchor_B_m);
  }
  for (const auto& bend : setup.bends) {
    for (const int body : {bend.body_A, bend.body_B, bend.body_C}) digest.add(static_cast<std::uint64_t>(body));
    digest.add(bend.stiffness_N_m_per_rad);
    digest.add(bend.rest_angle_rad);
  }
  for (const auto& actuator : setup.actuators) {
    digest.add(static_cast<std::uint64_t>(actuator.kind));
    digest.add(static_cast<std::uint64_t>(actuator.body_A));
    digest.add(static_cast<std::uint64_t>(actuator.body_B));
    add_numbers(digest, actuator.direction);
    add_numbers(digest, actuator.anchor_A_m);
    add_numbers(digest, actuator.anchor_B_m);
  }
  return digest.value();
}

std::uint64_t state_digest(std::int64_t step, const MotionState& state) {
  Digest digest;
  digest.add(static_cast<std::uint64_t>(step));
  add_numbers(digest, state.position_m);
  add_numbers(digest, state.orientation_wxyz);
  add_numbers(digest, state.velocity_m_per_s);
  add_numbers(digest, state.angular_momentum_N_m_s);
  return digest.value();
}

void write_state(const std::string& path, const StateLabel& label, const MotionState& state,
                 const std::function<void()>& on_piece) {
  const auto bodies = static_cast<std::size_t>(state.bodies());
  Words words{magic, version, label.case_digest, static_cast<std::uint64_t>(label.step), bodies};
  words.reserve(header_words + words_per_body * bodies + 1);
  append(words, state.position_m);
  append(words, state.orientation_wxyz);
  append(words, state.velocity_m_per_s);
  append(words, state.angular_momentum_N_m_s);
  words.push_back(digest_of(words));

  write_durably(path, std::as_bytes(std::span(words)), on_piece);
}

std::int64_t read_state(const std::string& path, std::uint64_t case_digest, MotionState& state,
                        const std::function<void()>& on_piece) {
  const std::string remedy = "Resume from another checkpoint.";
  const auto bodies = static_cast<std::size_t>(state.bodies());
  const std::size_t expected = header_words + words_per_body * bodies + 1;

  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "could not be opened (" + std::string(std::strerror(errno)) + ")", remedy);
  Words words(expected + 1);  // one more than fits, to notice a file that is too long
  read_all(file, words, on_piece);

  if (words.size() < header_words || words[0] != magic) fail(path, "is not a saved body state", remedy);
  if (words[1] != version) {
    fail(path, "has format version " + std::to_string(words[1]) + " (this program reads version 1)",
         "Resume with the program that wrote it.");
  }
  if (words[2] != case_digest || words[4] != bodies) {
    fail(path, "belongs to another case (bodies, springs, actuators, step or integrator differ)",
         "Resume with the case file that wrote it.");
  }
  const auto content = std::span<const std::uint64_t>(words);
  if (words.size() != expected || content.back() != digest_of(content.first(expected - 1))) {
    fail(path, "is damaged (wrong length or checksum)", remedy);
  }
  auto numbers = content.subspan(header_words);
  take(numbers, state.position_m);
  take(numbers, state.orientation_wxyz);
  take(numbers, state.velocity_m_per_s);
  take(numbers, state.angular_momentum_N_m_s);
  return static_cast<std::int64_t>(words[3]);
}

}  // namespace copepod::body
