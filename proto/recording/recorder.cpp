#include "recording/recorder.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <iostream>
#include <utility>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>

#include "contract/errors.hpp"
#include "conversion/enumerations.hpp"
#include "copepod/v1/envelope.pb.h"
#include "copepod/v1/recording.pb.h"
#include "system/durable_file.hpp"
#include "system/process.hpp"

namespace copepod::recording {

namespace {

constexpr int kWorthWriting = 1 << 20;
constexpr std::size_t kMostPending = std::size_t{64} << 20;
constexpr std::chrono::milliseconds kInterval{100};

template <class Duration>
std::uint64_t nanoseconds(Duration duration) {
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(duration).count());
}

/// Monotonic clocks count from the start of the machine: equal boot ids, comparable times.
std::string clock_name() {
  std::ifstream stream("/proc/sys/kernel/random/boot_id");
  std::string name;
  return std::getline(stream, name) ? name : host_name();
}

void add_with_imports(const google::protobuf::FileDescriptor& file, google::protobuf::FileDescriptorSet& schema) {
  for (const auto& known : schema.file())
    if (known.name() == file.name()) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_with_imports(*file.dependency(i), schema);
  file.CopyTo(schema.add_file());
}

/// The schema of recordings and of all messages, imported files first.
google::protobuf::FileDescriptorSet recording_schema() {
  google::protobuf::FileDescriptorSet schema;
  add_with_imports(*v1::Envelope::descriptor()->file(), schema);
  add_with_imports(*v1::Record::descriptor()->file(), schema);
  return schema;
}

}  // namespace

using conversion::to_wire;
using google::protobuf::util::SerializeDelimitedToZeroCopyStream;
/// @param fill  sets all fields of a record that may hold those of an earlier one
template <class Fill>
void Recorder::append(const Fill& fill) {
  std::unique_lock lock(mutex_);
  room_.wait(lock, [this] { return pending_bytes_ < kMostPending; });
  if (count_ == pending_.size()) pending_.emplace_back();
  v1::Record& record = pending_[count_++];
  fill(record);
  pending_bytes_ += record.ByteSizeLong();
  if (pending_bytes_ > kWorthWriting) work_.notify_one();
}

Recorder::Recorder(const std::string& path, const std::string& process, int rank)
    : path_(path), descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600)) {
  if (descriptor_ < 0)
    throw StorageError("the recording " + path + " cannot be made (" + std::strerror(errno) + "). " +
                       remedy_for(errno, "Check the run directory, or switch output.wire and output.trace off."));
  append([&](v1::Record& record) {
    v1::RecordingHeader& header = *record.mutable_header();
    header.set_process(process);
    header.set_rank(rank);
    header.set_host(host_name());
    header.set_clock(clock_name());
    header.set_monotonic_ns(nanoseconds(Clock::now().time_since_epoch()));
    header.set_utc_ns(nanoseconds(std::chrono::system_clock::now().time_since_epoch()));
  });
  thread_ = std::thread([this] {
    block_signals();
    write_in_background();
  });
}

Recorder::~Recorder() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  work_.notify_one();
  thread_.join();
}

void Recorder::add_phase(std::string_view name, std::int64_t step, Clock::time_point begin, Clock::time_point end) {
  append([&](v1::Record& record) {
    v1::RecordedPhase& phase = *record.mutable_phase();
    phase.mutable_name()->assign(name);
    phase.set_step(step);
    phase.set_begin_ns(nanoseconds(begin.time_since_epoch()));
    phase.set_duration_ns(nanoseconds(end - begin));
  });
}

void Recorder::add_message(Clock::time_point time, Direction direction, const Speaker& speaker,
                           std::span<const std::byte> envelope) {
  append([&](v1::Record& record) {
    v1::RecordedMessage& message = *record.mutable_message();
    message.set_time_ns(nanoseconds(time.time_since_epoch()));
    message.set_direction(to_wire<v1::Direction>(direction));
    message.set_role(speaker.role ? to_wire<v1::Role>(*speaker.role) : v1::ROLE_UNSPECIFIED);
    message.set_lane(speaker.lane ? to_wire<v1::Lane>(*speaker.lane) : v1::LANE_UNSPECIFIED);
    message.set_name(speaker.name);
    message.set_envelope(envelope.data(), envelope.size());
  });
}

void Recorder::write_in_background() {
  google::protobuf::io::FileOutputStream file(descriptor_, kWorthWriting);
  file.SetCloseOnDelete(true);
  SerializeDelimitedToZeroCopyStream(recording_schema(), &file);
  std::vector<v1::Record> records;
  bool complete = true;
  std::unique_lock lock(mutex_);
  for (bool last = false; !last;) {
    work_.wait_for(lock, kInterval, [this] { return closing_ || pending_bytes_ > kWorthWriting; });
    last = closing_;
    std::swap(records, pending_);
    const std::size_t count = std::exchange(count_, 0);
    pending_bytes_ = 0;
    lock.unlock();
    room_.notify_one();
    for (std::size_t i = 0; i < count; ++i) SerializeDelimitedToZeroCopyStream(records[i], &file);
    const bool written = file.Flush();  // never again once it failed
    lock.lock();
    if (!written && complete)
      std::cerr << "warning: The recording " << path_ << " is incomplete (" << std::strerror(file.GetErrno())
                << "). Free some space, or record less." << std::endl;
    complete = written;
  }
}

void open_timeline(Timeline& timeline, const std::string& folder, const std::string& process, int rank) {
  const std::string path = folder + "/" + process + ".rank" + std::to_string(rank) + ".rec";
  // std::function requires a copyable target, hence shared ownership despite a single owner.
  const auto recorder = std::make_shared<Recorder>(path, process, rank);
  timeline.open([recorder](std::string_view name, std::int64_t step, auto begin, auto end) {
    recorder->add_phase(name, step, begin, end);
  });
}

bool RecordingRouter::receive(transport::Frame& frame, transport::Duration wait) {
  if (!router_->receive(frame, wait)) return false;
  const auto now = Clock::now();
  recorder_.add_message(now, Direction::from_component, speaker_of(frame.peer, frame.bytes()), frame.bytes());
  return true;
}

bool RecordingRouter::send(const std::string& peer, transport::Bytes bytes) {
  const auto now = Clock::now();
  if (!router_->send(peer, bytes)) return false;
  recorder_.add_message(now, Direction::to_component, speaker_of(peer, {}), bytes);
  return true;
}

/// A peer is identified by its Hello; until then it is unknown.
Speaker RecordingRouter::speaker_of(const std::string& peer, transport::Bytes bytes) {
  if (const auto known = speakers_.find(peer); known != speakers_.end()) return known->second;
  try {
    if (bytes.empty() || decoder_.parse(bytes) != session::MessageKind::hello) return {};
    session::Hello hello;
    decoder_.read(hello);
    return speakers_[peer] = {hello.role, hello.lane, hello.name};
  } catch (const conversion::MalformedMessage&) {
    return {};
  }
}

}  // namespace copepod::recording
