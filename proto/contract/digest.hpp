#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

namespace copepod {

/// 64-bit mixing function (finaliser of splitmix64, Steele et al. 2014): every input bit affects every output bit.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Digest of a sequence: feed values in order. For states that are spread over ranks, digest each cell with
/// its global index and add the results modulo 2^64, so that the decomposition does not matter.
class Digest {
 public:
  constexpr explicit Digest(std::uint64_t seed = 0) : state_(mix_bits(seed)) {}                 ///< of nothing yet
  constexpr void add(std::uint64_t value) { state_ = mix_bits(state_ ^ value); }                ///< the next value
  constexpr void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }                ///< by its bits
  constexpr void add(float value) { add(std::uint64_t{std::bit_cast<std::uint32_t>(value)}); }  ///< by its bits
  /// All numbers of a range or, column by column, of a matrix.
  constexpr void add_all(const auto& values) {
    for (auto value = values.data(); value != values.data() + values.size(); ++value) add(*value);
  }
  [[nodiscard]] constexpr std::uint64_t value() const { return state_; }  ///< of all so far

 private:
  std::uint64_t state_;
};

/// Digest of bytes.
constexpr std::uint64_t digest_of(std::string_view bytes) {
  Digest digest;
  for (const char byte : bytes) digest.add(std::uint64_t{static_cast<unsigned char>(byte)});
  return digest.value();
}

}  // namespace copepod
