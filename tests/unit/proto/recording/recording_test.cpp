#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "copepod/v1/recording.pb.h"
#include "in_memory.hpp"
#include "recording/recorder.hpp"
#include "temporary_folder.hpp"

namespace copepod::recording {
namespace {

class Recording : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path(name); }

  /// All records behind schema and header; fails the test if these are missing, or the end is not that of a record.
  [[nodiscard]] std::vector<v1::Record> records_of(const std::string& name) const {
    using google::protobuf::util::ParseDelimitedFromZeroCopyStream;
    std::ifstream file(path(name), std::ios::binary);
    google::protobuf::io::IstreamInputStream stream(&file);
    google::protobuf::FileDescriptorSet schema;
    bool ended = false;
    EXPECT_TRUE(ParseDelimitedFromZeroCopyStream(&schema, &stream, &ended));
    EXPECT_EQ(schema.file_size(), 7);
    EXPECT_EQ(schema.file().rbegin()->name(), "copepod/v1/recording.proto");
    std::vector<v1::Record> records;
    for (v1::Record record; ParseDelimitedFromZeroCopyStream(&record, &stream, &ended); record.Clear())
      records.push_back(record);  // parsing merges into what is there
    EXPECT_TRUE(ended);
    EXPECT_TRUE(!records.empty() && records[0].has_header());
    if (!records.empty()) records.erase(records.begin());
    return records;
  }

  TemporaryFolder folder_;
};

using transport::bytes_of;

TEST_F(Recording, KeepsEveryRecordInItsOrder) {
  {
    Recorder recorder(path("a"), "body", 0);
    for (int i = 0; i < 5000; ++i) recorder.add_phase("integrate", i, Clock::now(), Clock::now());
  }
  const auto records = records_of("a");
  ASSERT_EQ(records.size(), 5000U);
  for (std::size_t i = 0; i < 5000; ++i) EXPECT_EQ(records[i].phase().step(), i);
}

TEST_F(Recording, HoldsMoreThanItsBuffer) {
  const std::string large(10 << 20, 'x');
  {
    Recorder recorder(path("a"), "coupler", 0);
    for (int i = 0; i < 12; ++i) recorder.add_message(Clock::now(), Direction::to_component, {}, bytes_of(large));
  }
  const auto records = records_of("a");
  ASSERT_EQ(records.size(), 12U);
  for (const auto& record : records) EXPECT_EQ(record.message().envelope(), large);
}

TEST_F(Recording, IsOnTheDiskSoonAfterwards) {
  Recorder recorder(path("a"), "fluid", 0);
  while (std::filesystem::file_size(path("a")) == 0) usleep(1000);
  const auto before = std::filesystem::file_size(path("a"));
  recorder.add_phase("now", 0, Clock::now(), Clock::now());
  while (std::filesystem::file_size(path("a")) == before) usleep(1000);
  EXPECT_EQ(records_of("a").back().phase().name(), "now");
}

TEST_F(Recording, NeverOverwritesAnother) {
  std::ofstream(path("a")) << "precious";
  EXPECT_THROW(Recorder(path("a"), "coupler", 0), StorageError);
  EXPECT_THROW(Recorder(path("missing/a"), "coupler", 0), StorageError);
}

TEST_F(Recording, IsForItsOwnerOnlySinceItHoldsTheToken) {
  const Recorder recorder(path("a"), "coupler", 0);
  EXPECT_EQ(std::filesystem::status(path("a")).permissions() & std::filesystem::perms::mask,
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(Recording, OnAFullDiskWarnsOnceAndNeverWaits) {
  // /dev/full cannot be made anew, so a limit on the size of files takes its place.
  signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1 << 20, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  testing::internal::CaptureStderr();
  {
    Recorder recorder(path("a"), "coupler", 0);
    const std::string large(10 << 20, 'x');
    for (int i = 0; i < 12; ++i) recorder.add_message(Clock::now(), Direction::to_component, {}, bytes_of(large));
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: The recording " + path("a") +
                                                        " is incomplete (File too large). Free some space, or record "
                                                        "less.\n");
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
  const auto records = records_of("a");
  ASSERT_EQ(records.size(), 2U);  // Hello, answer; what never left is not there
  for (const auto& record : records) {
    EXPECT_EQ(record.message().role(), v1::ROLE_BODY);
    EXPECT_EQ(record.message().lane(), v1::LANE_CONTROL);
    EXPECT_GT(record.message().time_ns(), 0U);
  }
  EXPECT_EQ(records[0].message().direction(), v1::DIRECTION_FROM_COMPONENT);
  EXPECT_EQ(records[0].message().envelope(), said);
  EXPECT_EQ(records[1].message().direction(), v1::DIRECTION_TO_COMPONENT);
  EXPECT_EQ(records[1].message().envelope(), "answer");
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
  const auto records = records_of("fluid.rank3.rec");
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(records[0].phase().name(), "bulk");
  EXPECT_EQ(records[0].phase().step(), 7);
  EXPECT_EQ(records[0].phase().duration_ns(), 300U);
}

}  // namespace
}  // namespace copepod::recording
