#pragma once

#include <atomic>

namespace copepod::coupler {

/// The signal that asked this process to stop, 0 for none. SIGINT and SIGTERM set it once `watch_signals` was
/// called; everybody who waits looks at it. A second signal kills the process the ordinary way.
const std::atomic<int>& stop_signal();

void watch_signals();

}  // namespace copepod::coupler
