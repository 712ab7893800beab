#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "contract/timeline.hpp"
#include "conversion/codec.hpp"
#include "session/messages.hpp"
#include "transport/lanes.hpp"

namespace copepod::v1 {
class Record;
}

namespace copepod::recording {

using Clock = Timeline::Clock;

enum class Direction { to_component, from_component };

/// The component and lane at the other end; absent: unknown.
struct Speaker {
  std::optional<session::Role> role;
  std::optional<session::Lane> lane;
  std::string name = {};  ///< of a controller
};

/// A recording of this process: a new file of length-delimited Protobuf messages, first the schema, then a
/// copepod.v1.Record with a header, then one per `add_…` [docs/recording.md]. A thread of its own writes, so
/// that recording never waits for a disk: `add_…` copies into memory, and the file follows within 0.1 s. Waits
/// only if the disk is 64 MiB behind; once the disk is full nothing more is recorded.
class Recorder {
 public:
  /// @param process  "coupler", "fluid" or "body"
  /// @throws StorageError if the file exists or cannot be made
  Recorder(const std::string& path, const std::string& process, int rank);
  /// Writes what is left.
  ~Recorder();

  void add_phase(std::string_view name, std::int64_t step, Clock::time_point begin, Clock::time_point end);
  void add_message(Clock::time_point time, Direction direction, const Speaker& speaker,
                   std::span<const std::byte> envelope);

 private:
  template <class Fill>
  void append(const Fill& fill);
  void write_in_background();

  std::string path_;
  int descriptor_;
  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable room_;
  std::vector<v1::Record> pending_;  ///< those behind the first `count_` are old ones, kept for their memory
  std::size_t count_ = 0;
  std::size_t pending_bytes_ = 0;
  bool closing_ = false;
  std::thread thread_;
};

/// Phases of `timeline` go to a new file `folder`/`process`.rank`rank`.rec from now on, until it is closed. A
/// phase then costs some 100 ns.
/// @param process  "coupler", "fluid" or "body"
/// @throws StorageError
void open_timeline(Timeline& timeline, const std::string& folder, const std::string& process, int rank);

/// A router that records every message which another one sends and receives: both lanes, both components.
class RecordingRouter final : public transport::Router {
 public:
  /// @throws StorageError if the file exists or cannot be made
  RecordingRouter(std::unique_ptr<transport::Router> router, const std::string& file)
      : router_(std::move(router)), recorder_(file, "coupler", 0) {}

  bool receive(transport::Frame& frame, transport::Duration wait) override;
  bool send(const std::string& peer, transport::Bytes bytes) override;
  bool connected(const std::string& peer) override { return router_->connected(peer); }
  std::string next_remark() override { return router_->next_remark(); }

 private:
  Speaker speaker_of(const std::string& peer, transport::Bytes bytes);

  std::unique_ptr<transport::Router> router_;
  Recorder recorder_;
  conversion::Decoder decoder_;
  std::map<std::string, Speaker> speakers_;
};

}  // namespace copepod::recording
