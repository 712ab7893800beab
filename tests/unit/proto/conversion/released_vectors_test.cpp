// One frame of every message of each released protocol version (tests/released): read into the structs of the contract
// and written again, they are the same bytes. The Python kit's are in tests/protocol/schema_versions_test.py.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "conversion/codec.hpp"

namespace copepod::conversion {
namespace {

using session::MessageKind;

std::vector<std::byte> bytes_of(const std::string& hexadecimal) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < hexadecimal.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoi(hexadecimal.substr(i, 2), nullptr, 16)));
  return bytes;
}

/// Reads each message by its kind and writes what was read.
class Repeater {
 public:
  /// @param message  as protocol_vectors.py has it: the arrays of an exchange are those of the setup before it
  std::vector<std::byte> repeat(std::span<const std::byte> message) {
    const Bytes written = write(decoder_.parse(message));
    return {written.begin(), written.end()};
  }

 private:
  Bytes write(MessageKind kind) {
    switch (kind) {
      case MessageKind::hello:
        return repeated<session::Hello>();
      case MessageKind::welcome:
        return repeated<session::Welcome>();
      case MessageKind::refusal:
        return repeated<session::Refusal>();
      case MessageKind::fluid_setup:
        return repeated<FluidSetup>();
      case MessageKind::body_setup: {
        BodySetup setup;
        decoder_.read(setup);
        actuators_ = static_cast<Eigen::Index>(setup.actuators.size());
        return encoder_.encode(decoder_.header(), setup);
      }
      case MessageKind::configured:
        return repeated<session::Configured>();
      case MessageKind::kinematics:
        return repeated<Kinematics>(bodies);
      case MessageKind::loads:
        return repeated<Loads>(bodies);
      case MessageKind::applied_loads:
        return repeated<AppliedLoads>(bodies, actuators_, driving_nodes);
      case MessageKind::saved:
        return repeated<session::Saved>();
      case MessageKind::summary:
        return repeated<SolverSummary>();
      case MessageKind::ping:
        return repeated<session::Ping>();
      case MessageKind::pong:
        return repeated<session::Pong>();
      case MessageKind::failure:
        return repeated<FailureReport>();
      case MessageKind::save:
      case MessageKind::restore: {
        session::CheckpointPath path;
        decoder_.read(path);
        return encoder_.encode(decoder_.header(), kind, path);
      }
      case MessageKind::abort: {
        FailureReport failure;
        decoder_.read(failure);
        return encoder_.encode_abort(decoder_.header(), failure);
      }
      default:
        return encoder_.encode(decoder_.header(), kind);
    }
  }

  template <class Struct, class... Sizes>
  Bytes repeated(Sizes... sizes) {
    Struct content;
    decoder_.read(content, sizes...);
    return encoder_.encode(decoder_.header(), content);
  }

  static constexpr Eigen::Index bodies = 2, driving_nodes = 1;
  Eigen::Index actuators_ = 0;
  Decoder decoder_;
  Encoder encoder_;
};

TEST(ReleasedVectors, AreReadAndWrittenAsTheSameBytes) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RELEASED)) {
    const std::string name = entry.path().filename();
    if (!name.ends_with("_vectors.json")) continue;
    ++files;
    Repeater repeater;
    for (const auto& vector : nlohmann::json::parse(std::ifstream(entry.path())).at("vectors")) {
      SCOPED_TRACE(name + ", " + vector.at("message").get<std::string>());
      const std::vector<std::byte> frame = bytes_of(vector.at("frame"));
      EXPECT_EQ(repeater.repeat(frame), frame);
    }
  }
  EXPECT_GE(files, 1);
}

}  // namespace
}  // namespace copepod::conversion
