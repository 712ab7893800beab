#include "recording/recording_router.hpp"

namespace copepod::recording {

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
    return speakers_[peer] = {hello.role, hello.lane};
  } catch (const conversion::MalformedMessage&) {
    return {};
  }
}

}  // namespace copepod::recording
