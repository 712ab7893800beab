#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "contract/errors.hpp"

namespace copepod::coupler {

/// Reports to the deploy command what happens: one JSON object per line, each flushed.
class Events {
 public:
  /// @param stream  must outlive this object
  explicit Events(std::ostream& stream) : stream_(stream) {}

  /// @param phase  starting, handshake, configuring, running, checkpointing or finishing
  void phase(const std::string& phase);
  void progress(std::int64_t step, std::int64_t steps, double steps_per_s, double remaining_s);
  void failure(const FailureReport& report);
  void finished(const std::string& summary_path);
  void notice(const std::string& text);  ///< something worth a line that does not end the run

 private:
  void write(const nlohmann::ordered_json& event);
  std::ostream& stream_;
};

}  // namespace copepod::coupler
