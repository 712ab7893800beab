// The arrays of an exchange are written and read without Protobuf's message objects: the bytes are Protobuf's
// all the same, and whatever else Protobuf allows is read too.

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "conversion/codec.hpp"
#include "conversion/finite.hpp"

namespace copepod::conversion {
namespace {

using session::Header;
using session::MessageKind;

class Wire {
 public:
  Wire& raw(std::initializer_list<int> bytes) {
    for (const int byte : bytes) bytes_.push_back(static_cast<std::byte>(byte));
    return *this;
  }
  Wire& numbers(std::initializer_list<double> values) {
    for (const double value : values) {
      for (const std::byte byte : std::bit_cast<std::array<std::byte, sizeof(value)>>(value)) bytes_.push_back(byte);
    }
    return *this;
  }
  Wire& then(const Wire& more) {
    bytes_.insert(bytes_.end(), more.bytes_.begin(), more.bytes_.end());
    return *this;
  }
  /// Tag byte, length and content, up to 127 bytes.
  Wire& part(int tag, const Wire& content) { return raw({tag, static_cast<int>(content.bytes_.size())}).then(content); }
  /// The Envelope's field `loads`, 31, whose tag takes two bytes.
  Wire& loads(const Wire& content) { return raw({0xfa}).part(0x01, content); }

  [[nodiscard]] std::vector<std::byte> with_checksum() const {
    auto bytes = bytes_;
    bytes.resize(bytes.size() + kChecksumBytes);
    write_checksum(bytes);
    return bytes;
  }

 private:
  std::vector<std::byte> bytes_;
};

/// Protocol 2, sequence 3, step 2.
Wire header() { return Wire().raw({0x08, 2, 0x28, 3, 0x38, 4}); }
Wire force() { return Wire().part(0x0a, Wire().numbers({1, 2, 3})); }
Wire torque() { return Wire().part(0x12, Wire().numbers({4, 5, 6})); }
Wire both() { return force().then(torque()); }

Loads expected() {
  Loads loads;
  loads.step = 2;
  loads.resize(1);
  loads.force_N << 1, 2, 3;
  loads.torque_N_m << 4, 5, 6;
  return loads;
}

void expect_read(const std::vector<std::byte>& message) {
  Decoder decoder;
  ASSERT_EQ(decoder.parse(message), MessageKind::loads);
  EXPECT_EQ(decoder.header().sequence, 3U);
  Loads loads;
  decoder.read(loads, 1);
  EXPECT_EQ(loads.step, 2);
  EXPECT_EQ(loads.force_N, expected().force_N);
  EXPECT_EQ(loads.torque_N_m, expected().torque_N_m);
}

TEST(PackedArrays, AreWrittenAsProtobufDoes) {
  Header request;
  request.sequence = 3;
  Encoder encoder;
  const Bytes bytes = encoder.encode(request, expected());
  EXPECT_EQ(std::vector(bytes.begin(), bytes.end()), header().loads(both()).with_checksum());
  Loads nothing;
  nothing.step = 2;
  const Bytes empty = encoder.encode(request, nothing);
  EXPECT_EQ(std::vector(empty.begin(), empty.end()), header().loads(Wire()).with_checksum());
}

TEST(PackedArrays, AreReadInWhateverWayProtobufAllows) {
  expect_read(header().loads(both()).with_checksum());
  expect_read(Wire().loads(both()).then(header()).with_checksum());
  expect_read(header().loads(force()).loads(torque()).with_checksum());  // merged
  expect_read(header().loads(torque().then(force())).with_checksum());
  expect_read(header().raw({0xa2, 0x01, 0}).loads(both()).with_checksum());  // the last one of a oneof counts
  expect_read(header().loads(both().raw({0x48, 7})).with_checksum());        // an unknown number
  expect_read(header().loads(both().part(0x1a, Wire().numbers({7}))).with_checksum());  // an unknown array
  const Wire rest = Wire().part(0x0a, Wire().numbers({2, 3}));
  expect_read(header().loads(Wire().part(0x0a, Wire().numbers({1})).then(torque()).then(rest)).with_checksum());
  expect_read(header().loads(Wire().raw({0x09}).numbers({1}).then(rest).then(torque())).with_checksum());  // not packed
}

TEST(PackedArrays, ThatHoldNoWholeNumbersAreRefused) {
  Wire force_and_a_byte = Wire().part(0x0a, Wire().numbers({1, 2, 3}).raw({0}));
  Decoder decoder;
  EXPECT_THROW(decoder.parse(header().loads(force_and_a_byte.then(torque())).with_checksum()), MalformedMessage);
}

TEST(PackedArrays, ThatReachIntoTheChecksumAreRefused) {
  const Wire torque_without_its_end = Wire().raw({0x12, 24}).numbers({4}).raw({0, 0, 0, 0, 0, 0, 0});
  const Wire reaching = Wire().raw({0xfa, 0x01, 26 + 26}).then(force()).then(torque_without_its_end);
  Decoder decoder;
  EXPECT_THROW(decoder.parse(header().then(reaching).with_checksum()), MalformedMessage);
}

TEST(PackedArrays, HaveTheChecksumOfTheReference) {
  std::vector<std::byte> message(5000 + kChecksumBytes);
  for (std::size_t i = 0; i < message.size(); ++i) message[i] = static_cast<std::byte>(i % 251);
  // python3-xxhash: xxh3_64_hexdigest(bytes(i % 251 …))
  for (const auto& [size, hash] : {std::pair{0U, 0x2d06800538d394c2U}, std::pair{5000U, 0xb418500fc42320eeU}}) {
    write_checksum(std::span(message).first(size + kChecksumBytes));
    std::uint64_t found = 0;
    std::memcpy(&found, message.data() + size + 1, sizeof found);
    EXPECT_EQ(found, hash);
    message[0] = std::byte{0};
    for (std::size_t i = 1; i < 1 + kChecksumBytes; ++i) message[i] = static_cast<std::byte>(i);
  }
}

TEST(CopyFinite, CopiesWhateverTheLengthAndAlignment) {
  std::vector<double> numbers(40);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = 1.0 / (1.0 + static_cast<double>(i));
  for (std::size_t offset = 0; offset < 8; ++offset) {
    std::vector<std::byte> source(offset + sizeof(double) * numbers.size());
    std::memcpy(source.data() + offset, numbers.data(), sizeof(double) * numbers.size());
    for (std::size_t count = 0; count <= numbers.size(); ++count) {
      std::vector<double> target(count);
      EXPECT_TRUE(copy_finite(source.data() + offset, count, target.data()));
      EXPECT_TRUE(std::equal(target.begin(), target.end(), numbers.begin()));
    }
  }
}

TEST(CopyFinite, NoticesANumberThatIsNotFiniteWhereverItIs) {
  using Limits = std::numeric_limits<double>;
  std::vector<double> target(21);
  for (const double bad : {Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(), -Limits::quiet_NaN()}) {
    for (std::size_t place = 0; place < target.size(); ++place) {
      std::vector<double> numbers(target.size(), -Limits::max());
      EXPECT_TRUE(copy_finite(numbers.data(), numbers.size(), target.data()));
      numbers[place] = bad;
      EXPECT_FALSE(copy_finite(numbers.data(), numbers.size(), target.data()));
    }
  }
}

}  // namespace
}  // namespace copepod::conversion
