#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

namespace copepod {

/// The phases of one thread's work, for a trace (`output: {trace: true}`). Off until it is opened: phases are
/// then dropped.
class Timeline {
 public:
  using Clock = std::chrono::steady_clock;  ///< of all processes of a machine
  /// Takes a phase: its name, coupling step, begin and end.
  using Sink = std::function<void(std::string_view, std::int64_t, Clock::time_point, Clock::time_point)>;

  void open(Sink sink) { sink_ = std::move(sink); }              ///< from now on phases go there
  void close() { sink_ = nullptr; }                              ///< from now on phases are dropped
  [[nodiscard]] bool is_on() const { return sink_ != nullptr; }  ///< whether it is open

  /// Coupling step of the phases that follow.
  void set_step(std::int64_t step) { step_ = step; }

  void add(std::string_view name, Clock::time_point begin, Clock::time_point end) {
    if (sink_) sink_(name, step_, begin, end);
  }  ///< a phase of the current step

 private:
  Sink sink_;
  std::int64_t step_ = -1;
};

/// Adds its own lifetime to a timeline as one phase.
class Span {
 public:
  /// @param name  a literal
  Span(Timeline& timeline, std::string_view name) : timeline_(timeline), name_(name) {}
  Span(const Span&) = delete;
  Span& operator=(const Span&) = delete;
  ~Span() { timeline_.add(name_, begin_, Timeline::Clock::now()); }

 private:
  Timeline& timeline_;
  std::string_view name_;
  Timeline::Clock::time_point begin_ = Timeline::Clock::now();
};

}  // namespace copepod
