#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>
#include <zlib.h>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "conversion/encoder.hpp"
#include "in_memory.hpp"
#include "recording/recording_router.hpp"
#include "recording/timeline.hpp"
#include "temporary_folder.hpp"

namespace copepod::recording {
namespace {

using Blocks = std::vector<std::string>;

class Recording : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path(name); }

  /// Contents of all blocks; fails the test where magic, length or checksum are wrong.
  [[nodiscard]] Blocks blocks_of(const std::string& name) const {
    std::ifstream stream(path(name), std::ios::binary);
    const std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    EXPECT_EQ(content.substr(0, 8),
              "\x89"
              "CPDREC\n");
    Blocks blocks;
    for (std::size_t place = 8; place < content.size();) {
      std::uint32_t length = 0;
      std::uint32_t crc = 0;
      std::memcpy(&length, &content[place], 4);
      std::memcpy(&crc, &content[place + 4], 4);
      blocks.push_back(content.substr(place + 8, length));
      EXPECT_EQ(crc, crc32(0, reinterpret_cast<const Bytef*>(blocks.back().data()), length));
      place += 8 + length;
    }
    return blocks;
  }

  TemporaryFolder folder_;
};

using transport::bytes_of;

TEST_F(Recording, KeepsEveryBlockInItsOrder) {
  {
    RecordFile file(path("a"), bytes_of("schema"));
    for (int i = 0; i < 5000; ++i) file.append(bytes_of("head "), bytes_of(std::to_string(i)));
  }
  const Blocks blocks = blocks_of("a");
  ASSERT_EQ(blocks.size(), 5001U);
  EXPECT_EQ(blocks[0], "schema");
  for (std::size_t i = 0; i < 5000; ++i) EXPECT_EQ(blocks[i + 1], "head " + std::to_string(i));
}

TEST_F(Recording, HoldsMoreThanItsBuffer) {
  const std::string large(10 << 20, 'x');
  {
    RecordFile file(path("a"), {});
    for (int i = 0; i < 12; ++i) file.append(bytes_of(large));
  }
  EXPECT_EQ(blocks_of("a").size(), 13U);
}

TEST_F(Recording, IsOnTheDiskSoonAfterwards) {
  RecordFile file(path("a"), {});
  file.append(bytes_of("now"));
  while (std::filesystem::file_size(path("a")) < 8 + 8 + 8 + 3) usleep(1000);
  EXPECT_EQ(blocks_of("a").back(), "now");
}

TEST_F(Recording, NeverOverwritesAnother) {
  std::ofstream(path("a")) << "precious";
  EXPECT_THROW(RecordFile(path("a"), {}), StorageError);
  EXPECT_THROW(RecordFile(path("missing/a"), {}), StorageError);
}

TEST_F(Recording, IsForItsOwnerOnlySinceItHoldsTheToken) {
  const RecordFile file(path("a"), {});
  EXPECT_EQ(std::filesystem::status(path("a")).permissions() & std::filesystem::perms::mask,
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

session::Hello hello_of(session::Role role, session::Lane lane) {
  session::Hello hello;
  hello.role = role;
  hello.lane = lane;
  return hello;
}

TEST_F(Recording, OfARouterHoldsWhatWentThroughItWithDirectionRoleAndLane) {
  transport::InMemoryWire wire;
  conversion::Encoder encoder;
  std::string said;
  {
    RecordingRouter router(wire.make_router(), path("a"));
    const auto dealer = wire.make_dealer("peer");
    transport::Frame frame;
    const auto bytes = encoder.encode(session::Header{}, hello_of(session::Role::body, session::Lane::control));
    said.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    dealer->send(bytes);
    ASSERT_TRUE(router.receive(frame, std::chrono::seconds(1)));
    EXPECT_FALSE(router.receive(frame, std::chrono::milliseconds(1)));
    EXPECT_TRUE(router.send("peer", bytes_of("answer")));
    EXPECT_FALSE(router.send("absent", bytes_of("lost")));
    EXPECT_TRUE(router.connected("peer"));
    EXPECT_FALSE(router.connected("absent"));
  }
  const Blocks blocks = blocks_of("a");
  ASSERT_EQ(blocks.size(), 4U);  // schema, header, Hello, answer; what never left is not there
  // Field 2 to 4 of RecordedMessage: direction, role, lane; last the envelope, field 15.
  const std::string from_component("\x10\x02\x18\x02\x20\x02\x7a", 7);
  const std::string to_component("\x10\x01\x18\x02\x20\x02\x7a", 7);
  EXPECT_NE(blocks[2].find(from_component), std::string::npos);
  EXPECT_TRUE(blocks[2].ends_with(said));
  EXPECT_NE(blocks[3].find(to_component), std::string::npos);
  EXPECT_TRUE(blocks[3].ends_with("answer"));
}

TEST_F(Recording, OfATimelineHoldsItsPhasesOnceItIsOpen) {
  Timeline timeline;
  const auto now = Clock::now();
  timeline.add("dropped", now, now);
  EXPECT_FALSE(timeline.is_on());
  open_timeline(timeline, folder_.path().string(), "fluid", 3);
  EXPECT_TRUE(timeline.is_on());
  timeline.set_step(7);
  timeline.add("bulk", now, now + std::chrono::nanoseconds(300));
  timeline.close();
  timeline.add("dropped", now, now);
  const Blocks blocks = blocks_of("fluid.rank3.rec");
  ASSERT_EQ(blocks.size(), 3U);
  EXPECT_NE(blocks[1].find("fluid"), std::string::npos);
  EXPECT_NE(blocks[2].find("bulk"), std::string::npos);
  EXPECT_TRUE(blocks[2].ends_with(std::string("\x20\xac\x02", 3)));  // field 4, duration: 300
}

}  // namespace
}  // namespace copepod::recording
