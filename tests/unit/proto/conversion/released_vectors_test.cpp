// One frame of every message of each released protocol version (tests/released), read into the structs of the contract
// and written again. Those of the Python kit are in tests/protocol/schema_versions_test.py.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "conversion/codec.hpp"
#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {
namespace {

using session::MessageKind;

std::vector<std::byte> bytes_of(const std::string& hexadecimal) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < hexadecimal.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoi(hexadecimal.substr(i, 2), nullptr, 16)));
  return bytes;
}

/// All fields of a message. This kit writes a contact and a model without content, which mean the same as none, and an
/// Abort with the step of the failure in it.
std::string fields_of(Bytes frame) {
  v1::Envelope envelope;
  EXPECT_TRUE(envelope.ParseFromArray(frame.data(), static_cast<int>(frame.size())));
  if (envelope.has_body_setup()) {
    v1::BodySetup& setup = *envelope.mutable_body_setup();
    if (setup.contact().ByteSizeLong() == 0) setup.clear_contact();
    if (setup.model().ByteSizeLong() == 0) setup.clear_model();
    envelope.clear_checksum();
  }
  if (envelope.has_abort()) {
    envelope.set_step(envelope.abort().failure().step());
    envelope.clear_checksum();
  }
  return envelope.DebugString();
}

/// Reads each message by its kind and writes what was read.
class Repeater {
 public:
  /// @param message  as protocol_vectors.py has it: the arrays of an exchange are those of the setup before it
  Bytes repeat(Bytes message) { return write(decoder_.parse(message)); }

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
      case MessageKind::controller_setup:
        return repeated<ControllerSetup>();
      case MessageKind::observation:
        return repeated<Observation>(3);
      case MessageKind::action: {
        std::vector<double> action(3);
        decoder_.read(action);
        return encoder_.encode(decoder_.header(), action);
      }
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

TEST(ReleasedVectors, AreReadAndWrittenAsTheSameFields) {
  int messages = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RELEASED)) {
    const std::string name = entry.path().filename();
    if (!name.ends_with("_vectors.json")) continue;
    Repeater repeater;
    const nlohmann::json content = nlohmann::json::parse(std::ifstream(entry.path()));
    for (const nlohmann::json& vector : content.at("vectors")) {
      SCOPED_TRACE(name + ", " + vector.at("message").get<std::string>());
      const std::vector<std::byte> frame = bytes_of(vector.at("frame"));
      EXPECT_EQ(fields_of(repeater.repeat(frame)), fields_of(frame));
      ++messages;
    }
  }
  EXPECT_GE(messages, 22);
}

}  // namespace
}  // namespace copepod::conversion
