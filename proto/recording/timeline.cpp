#include "recording/timeline.hpp"

#include <memory>

#include "recording/recorder.hpp"

namespace copepod::recording {

void open_timeline(Timeline& timeline, const std::string& folder, const std::string& process, int rank) {
  const std::string path = folder + "/" + process + ".rank" + std::to_string(rank) + ".rec";
  // std::function requires a copyable target, hence shared ownership despite a single owner.
  const auto recorder = std::make_shared<Recorder>(path, process, rank);
  timeline.open([recorder](std::string_view name, std::int64_t step, auto begin, auto end) {
    recorder->add_phase(name, step, begin, end);
  });
}

}  // namespace copepod::recording
