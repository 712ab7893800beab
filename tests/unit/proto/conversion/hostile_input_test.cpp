#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "conversion/codec.hpp"
#include "conversion/limits.hpp"
#include "samples.hpp"

namespace copepod::conversion {
namespace {

using session::Header;
using session::MessageKind;

std::vector<std::byte> copy(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

/// Reads whatever the bytes claim to be; only MalformedMessage may come out.
void read_anything(Decoder& decoder, Bytes bytes) {
  session::Hello hello;
  FluidSetup fluid_setup;
  BodySetup body_setup;
  Kinematics kinematics;
  Loads loads;
  AppliedLoads applied;
  SolverSummary summary;
  FailureReport failure;
  session::Pong pong;
  session::Configured configured;
  session::CheckpointPath path;
  switch (decoder.parse(bytes)) {
    case MessageKind::hello:
      return decoder.read(hello);
    case MessageKind::fluid_setup:
      return decoder.read(fluid_setup);
    case MessageKind::body_setup:
      return decoder.read(body_setup);
    case MessageKind::kinematics:
      return decoder.read(kinematics, 3);
    case MessageKind::loads:
      return decoder.read(loads, 3);
    case MessageKind::applied_loads:
      return decoder.read(applied, 3, 4, 2);
    case MessageKind::summary:
      return decoder.read(summary);
    case MessageKind::abort:
    case MessageKind::failure:
      return decoder.read(failure);
    case MessageKind::pong:
      return decoder.read(pong);
    case MessageKind::configured:
      return decoder.read(configured);
    case MessageKind::save:
    case MessageKind::restore:
      return decoder.read(path);
    default:
      return;
  }
}

/// True if the bytes were taken for a message.
bool is_taken(Decoder& decoder, Bytes bytes) {
  try {
    read_anything(decoder, bytes);
    return true;
  } catch (const MalformedMessage&) {
    return false;
  }
}

std::vector<std::vector<std::byte>> one_of_each() {
  Encoder encoder;
  const Header header{2, 0, 1, 2, 3, 0, 4};
  session::Hello hello;
  hello.session_token = "token";
  hello.capabilities = {"n", "v", {"a", "b"}};
  std::vector<std::vector<std::byte>> messages;
  messages.push_back(copy(encoder.encode(header, hello)));
  messages.push_back(copy(encoder.encode(header, sample_fluid_setup())));
  messages.push_back(copy(encoder.encode(header, sample_body_setup())));
  messages.push_back(copy(encoder.encode(header, sample_controller_setup())));
  messages.push_back(copy(encoder.encode(header, sample_observation(3))));
  messages.push_back(copy(encoder.encode(header, std::vector<double>{1.0, 2.0})));
  messages.push_back(copy(encoder.encode(header, sample_kinematics(3))));
  messages.push_back(copy(encoder.encode(header, sample_loads(3))));
  messages.push_back(copy(encoder.encode(header, sample_applied_loads(3, 4, 2))));
  messages.push_back(copy(encoder.encode(header, SolverSummary{1, 2, 3, {{"bulk", 1.0}}, {"map"}, {"wait"}})));
  messages.push_back(copy(encoder.encode(header, FailureReport{})));
  messages.push_back(copy(encoder.encode(header, session::Pong{})));
  messages.push_back(copy(encoder.encode(header, session::Configured{{0, 1}})));
  messages.push_back(copy(encoder.encode(header, MessageKind::save, session::CheckpointPath{"/a"})));
  return messages;
}

/// The first bytes of a message with a valid checksum.
std::vector<std::byte> with_checksum(const std::vector<std::byte>& message, std::size_t size) {
  std::vector<std::byte> bytes(message.begin(), message.begin() + static_cast<std::ptrdiff_t>(size));
  bytes.resize(size + kChecksumBytes);
  write_checksum(bytes);
  return bytes;
}

TEST(HostileInput, IntactMessagesAreTaken) {
  Decoder decoder;
  for (const auto& message : one_of_each()) EXPECT_TRUE(is_taken(decoder, message));
}

TEST(HostileInput, EveryTruncationIsNoticedAndNeverCrashesTheDecoder) {
  Decoder decoder;
  for (const auto& message : one_of_each()) {
    for (std::size_t size = 0; size < message.size(); ++size) {
      EXPECT_THROW(decoder.parse(Bytes(message).first(size)), DamagedMessage);
      is_taken(decoder, with_checksum(message, size));
    }
  }
}

TEST(HostileInput, EveryFlippedBitIsNoticed) {
  Decoder decoder;
  for (auto message : one_of_each()) {
    for (std::byte& byte : message) {
      for (int bit = 0; bit < 8; ++bit) {
        byte ^= std::byte(1U << bit);
        EXPECT_THROW(decoder.parse(message), DamagedMessage);
        byte ^= std::byte(1U << bit);
      }
    }
    EXPECT_TRUE(is_taken(decoder, message));
  }
}

TEST(HostileInput, FlippedBitsUnderARightChecksumNeverCrashTheDecoder) {
  Decoder decoder;
  std::mt19937_64 random(42);
  for (auto message : one_of_each()) {
    for (int round = 0; round < 3000; ++round) {
      auto broken = message;
      const auto flips = 1 + random() % 8;
      for (std::uint64_t i = 0; i < flips; ++i) broken[random() % broken.size()] ^= std::byte(1U << (random() % 8));
      is_taken(decoder, with_checksum(broken, broken.size() - kChecksumBytes));
    }
    EXPECT_TRUE(is_taken(decoder, message)) << "the decoder still works afterwards";
  }
}

TEST(HostileInput, RandomBytesNeverCrashTheDecoder) {
  Decoder decoder;
  std::mt19937_64 random(7);
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::byte> bytes(random() % 200);
    for (std::byte& byte : bytes) byte = std::byte(random() & 0xFFU);
    is_taken(decoder, bytes);
    is_taken(decoder, with_checksum(bytes, bytes.size()));
  }
}

TEST(HostileInput, AnotherNumberOfBodiesIsRefused) {
  Encoder encoder;
  Decoder decoder;
  decoder.parse(encoder.encode(Header{}, sample_kinematics(3)));
  Kinematics kinematics;
  EXPECT_THROW(decoder.read(kinematics, 2), MalformedMessage);
  EXPECT_THROW(decoder.read(kinematics, 4), MalformedMessage);
  decoder.parse(encoder.encode(Header{}, sample_applied_loads(3, 4, 2)));
  AppliedLoads applied;
  EXPECT_THROW(decoder.read(applied, 3, 4, 3), MalformedMessage);
  EXPECT_THROW(decoder.read(applied, 3, 3, 2), MalformedMessage);
}

TEST(HostileInput, ArraysOfDifferentLengthAreRefused) {
  Kinematics kinematics = sample_kinematics(3);
  kinematics.velocity_m_per_s.resize(3, 2);
  kinematics.velocity_m_per_s.setZero();
  Encoder encoder;
  Decoder decoder;
  decoder.parse(encoder.encode(Header{}, kinematics));
  Kinematics received;
  EXPECT_THROW(decoder.read(received, 3), MalformedMessage);
}

TEST(HostileInput, NumbersThatAreNotFiniteAreRefused) {
  Encoder encoder;
  Decoder decoder;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Loads loads = sample_loads(3);
    loads.torque_N_m(1, 2) = bad;
    decoder.parse(encoder.encode(Header{}, loads));
    Loads received;
    EXPECT_THROW(decoder.read(received, 3), MalformedMessage);
    FluidSetup setup = sample_fluid_setup();
    setup.boundaries[5].pressure_Pa = bad;
    decoder.parse(encoder.encode(Header{}, setup));
    EXPECT_THROW(decoder.read(setup), MalformedMessage);
    SolverSummary summary{1, 2, 3, {{"bulk", bad}}};
    decoder.parse(encoder.encode(Header{}, summary));
    EXPECT_THROW(decoder.read(summary), MalformedMessage);
  }
}

TEST(HostileInput, SpringsBetweenBodiesThatDoNotExistAreRefused) {
  Encoder encoder;
  Decoder decoder;
  for (const int index : {2, -1}) {
    BodySetup setup = sample_body_setup();
    setup.springs[0].body_B = index;
    decoder.parse(encoder.encode(Header{}, setup));
    BodySetup received;
    EXPECT_THROW(decoder.read(received), MalformedMessage);
  }
}

TEST(HostileInput, PlanesThatAreNoFaceAreRefused) {
  Encoder encoder;
  Decoder decoder;
  FluidSetup setup = sample_fluid_setup();
  setup.no_slip_plane = 6;
  decoder.parse(encoder.encode(Header{}, setup));
  EXPECT_THROW(decoder.read(setup), MalformedMessage);
}

std::string refusal_of(const FluidSetup& setup) {
  Encoder encoder;
  Decoder decoder;
  decoder.parse(encoder.encode(Header{}, setup));
  FluidSetup received;
  try {
    decoder.read(received);
  } catch (const MalformedMessage& error) {
    return error.what();
  }
  return "taken";
}

TEST(HostileInput, JointsOfBodiesThatAreNotTwoInOrderAreRefused) {
  for (const BodyPair& pair : {BodyPair{0, 2}, {1, 1}, {1, 0}, {-1, 0}}) {
    FluidSetup setup = sample_fluid_setup();
    setup.jointed = {pair};
    EXPECT_NE(refusal_of(setup), "taken") << pair.first << " and " << pair.second;
  }
}

TEST(HostileInput, FieldOutputOfNoStepsIsRefused) {
  const auto refusal = [](std::int64_t every, std::int64_t start, std::int64_t stop, std::int64_t sampled) {
    FluidSetup setup = sample_fluid_setup();
    setup.fields = {"/runs/a", every, start, stop, sampled, {}, {}, 0};
    return refusal_of(setup);
  };
  EXPECT_EQ(refusal(0, 0, 0, 0), "taken") << "no fields are requested";
  EXPECT_EQ(refusal(0, 5, 6, 1), "taken");
  EXPECT_NE(refusal(-1, 0, 0, 1).find("fields.every_steps is -1, less than 0"), std::string::npos);
  EXPECT_NE(refusal(0, -2, 50, 1).find("fields.mean_start is -2"), std::string::npos);
  EXPECT_NE(refusal(0, 0, -50, 1).find("fields.mean_stop is -50"), std::string::npos);
  EXPECT_NE(refusal(0, 0, 50, -1).find("fields.mean_every_steps is -1"), std::string::npos);
  EXPECT_NE(refusal(0, 0, 50, 0).find("fields.mean_every_steps of a mean is 0"), std::string::npos);
  EXPECT_NE(refusal(0, 50, 50, 1).find("fields.mean_start is 50, not before mean_stop 50"), std::string::npos);
}

TEST(HostileInput, FieldOutputOfNoCellsIsRefused) {
  const auto refusal = [](std::vector<std::int64_t> region, int compression) {
    FluidSetup setup = sample_fluid_setup();
    setup.fields.region_cells = std::move(region);
    setup.fields.compression = compression;
    return refusal_of(setup);
  };
  EXPECT_EQ(refusal({}, 9), "taken");
  EXPECT_EQ(refusal({0, 0, 3, 4, 0, 0}, 0), "taken");
  EXPECT_NE(refusal({0, 1}, 0).find("fields.region_cells has 2 entries, not 6"), std::string::npos);
  EXPECT_NE(refusal({0, 0, 4, 4, 0, 0}, 0).find("fields.region_cells has no cells"), std::string::npos);
  EXPECT_NE(refusal({0, 0, 4, 0, 0, 0}, 0).find("fields.region_cells has no cells"), std::string::npos);
  EXPECT_NE(refusal({0, 0, 0, 0, -1, 4}, 0).find("fields.region_cells is -1, less than 0"), std::string::npos);
  EXPECT_NE(refusal({}, 10).find("fields.compression is 10, more than 9"), std::string::npos);
}

TEST(HostileInput, SamplesAtAFaceThatNoDomainHasAreRefused) {
  const auto refusal = [](std::int64_t face) {
    FluidSetup setup = sample_fluid_setup();
    setup.flow.faces = {0, face};
    return refusal_of(setup);
  };
  EXPECT_EQ(refusal(5), "taken");
  EXPECT_NE(refusal(6).find("flow.faces has face 6, a domain has faces 0 to 5"), std::string::npos);
  EXPECT_NE(refusal(-1).find("flow.faces is -1, less than 0"), std::string::npos);
}

TEST(HostileInput, CellsBeyondCountingAreRefused) {
  const auto refusal = [](std::array<std::int64_t, 3> cells) {
    FluidSetup setup = sample_fluid_setup();
    setup.domain_cells = cells;
    return refusal_of(setup);
  };
  constexpr std::int64_t two_to_the_32 = std::int64_t{1} << 32;
  EXPECT_EQ(refusal({0, 0, 0}), "taken") << "solvers without a lattice";
  EXPECT_EQ(refusal({10000, 10000, 10000}), "taken");
  EXPECT_NE(refusal({10001, 10000, 10000}).find("more than 10^12 cells"), std::string::npos);
  EXPECT_NE(refusal({two_to_the_32, two_to_the_32, 0}).find("more than 10^12 cells"), std::string::npos);
  EXPECT_NE(refusal({4, -1, 4}).find("domain_cells is -1, less than 0"), std::string::npos);
}

TEST(HostileInput, SignalsThatHaveNoValueAreRefused) {
  const auto refusal = [](const Signal& signal) {
    FluidSetup setup = sample_fluid_setup();
    setup.boundaries[2].signal = signal;
    return refusal_of(setup);
  };
  EXPECT_EQ(refusal({.table = {}}), "taken");
  EXPECT_EQ(refusal({.kind = SignalKind::trapezoid, .period_steps = 20, .rise = 0.25, .table = {}}), "taken");
  EXPECT_EQ(refusal({.kind = SignalKind::table, .table = {{0.0, 1.0}}}), "taken");
  for (const Signal& signal :
       {Signal{.kind = SignalKind::sinusoid, .table = {}}, Signal{.kind = SignalKind::square, .table = {}},
        Signal{.kind = SignalKind::trapezoid, .period_steps = 20, .table = {}},
        Signal{.kind = SignalKind::trapezoid, .period_steps = 20, .rise = 0.26, .table = {}},
        Signal{.kind = SignalKind::sinusoid, .period_steps = 20, .rise = 0.2, .table = {}},
        Signal{.kind = SignalKind::table, .table = {}},
        Signal{.kind = SignalKind::table, .table = {{1.0, 1.0}, {1.0, 2.0}}},
        Signal{.kind = SignalKind::constant, .table = {{1.0, 1.0}}}})
    EXPECT_NE(refusal(signal).find("a signal lacks"), std::string::npos);
}

TEST(HostileInput, UnknownEnumerationValuesAreRefused) {
  FluidSetup setup = sample_fluid_setup();
  setup.collision = static_cast<CollisionKind>(40);
  Encoder encoder;
  Decoder decoder;
  decoder.parse(encoder.encode(Header{}, setup));
  EXPECT_THROW(decoder.read(setup), MalformedMessage);
}

TEST(HostileInput, AnotherMajorVersionIsRefusedExceptInAHello) {
  Encoder encoder;
  Decoder decoder;
  Header header;
  header.protocol_major = 3;
  EXPECT_THROW(decoder.parse(encoder.encode(header, session::Ping{})), MalformedMessage);
  EXPECT_EQ(decoder.parse(encoder.encode(header, session::Hello{})), MessageKind::hello);
}

TEST(HostileInput, OverlongTextsAndPathsAreRefused) {
  Encoder encoder;
  Decoder decoder;
  session::Hello hello;
  hello.host = std::string(kLimits.string_bytes + 1, 'x');
  decoder.parse(encoder.encode(Header{}, hello));
  EXPECT_THROW(decoder.read(hello), MalformedMessage);
  EXPECT_THROW(encoder.encode(Header{}, MessageKind::save, session::CheckpointPath{hello.host}), MalformedMessage);
}

TEST(HostileInput, AFailureCannotClaimSuccess) {
  Encoder encoder;
  Decoder decoder;
  FailureReport report;
  for (const int code : {0, 1, 4711, -5}) {
    report.code = static_cast<ExitCode>(code);
    decoder.parse(encoder.encode(Header{}, report));
    FailureReport received;
    decoder.read(received);
    EXPECT_EQ(received.code, ExitCode::solver_failed);
  }
}

}  // namespace
}  // namespace copepod::conversion
