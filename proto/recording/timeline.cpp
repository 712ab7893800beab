#include "recording/timeline.hpp"

namespace copepod::recording {

void Timeline::open(const std::string& folder, const std::string& process, int rank) {
  recorder_ = std::make_unique<Recorder>(folder + "/" + process + ".rank" + std::to_string(rank) + ".rec",
                                         process, rank);
}

Timeline& timeline() {
  static Timeline the_timeline;
  return the_timeline;
}

}  // namespace copepod::recording
