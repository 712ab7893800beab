#pragma once

#include <map>
#include <memory>
#include <string>

#include "conversion/decoder.hpp"
#include "recording/recorder.hpp"
#include "transport/router.hpp"

namespace copepod::recording {

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
