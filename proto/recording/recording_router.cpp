#include "recording/recording_router.hpp"

namespace copepod::recording {

using conversion::Direction;

bool RecordingRouter::receive(transport::Frame& frame, transport::Duration wait) {
  if (!router_->receive(frame, wait)) return false;
  const auto now = Clock::now();
  const Speaker& speaker = speaker_of(frame.peer, frame.bytes());
  recorder_.add_message({nanoseconds(now), Direction::from_component, speaker.role, speaker.lane}, frame.bytes());
  return true;
}

bool RecordingRouter::send(const std::string& peer, transport::Bytes bytes) {
  const auto now = Clock::now();
  if (!router_->send(peer, bytes)) return false;
  const Speaker& speaker = speaker_of(peer, {});
  recorder_.add_message({nanoseconds(now), Direction::to_component, speaker.role, speaker.lane}, bytes);
  return true;
}

/// A peer is identified by its Hello; until then it is unknown.
const RecordingRouter::Speaker& RecordingRouter::speaker_of(const std::string& peer, transport::Bytes bytes) {
  static const Speaker nobody;
  for (const Speaker& speaker : speakers_) {
    if (speaker.peer == peer) return speaker;
  }
  try {
    if (bytes.empty() || decoder_.parse(bytes) != session::MessageKind::hello) return nobody;
    session::Hello hello;
    decoder_.read(hello);
    return speakers_.emplace_back(Speaker{peer, hello.role, hello.lane});
  } catch (const conversion::MalformedMessage&) {
    return nobody;
  }
}

}  // namespace copepod::recording
