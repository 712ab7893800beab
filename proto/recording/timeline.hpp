#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "recording/recorder.hpp"

namespace copepod::recording {

/// What the solver's thread of this process does when, for a trace (`output: {trace: true}`). Off until it is
/// opened; then a phase costs some 100 ns. Used by one thread.
class Timeline {
 public:
  /// Phases go to a new file `folder`/`process`.rank`rank`.rec from now on.
  /// @throws StorageError
  void open(const std::string& folder, const std::string& process, int rank);

  /// Writes what is left; phases are dropped from now on.
  void close() { recorder_.reset(); }

  [[nodiscard]] bool is_on() const { return recorder_ != nullptr; }

  /// Coupling step of the phases that follow.
  void set_step(std::int64_t step) { step_ = step; }

  void add(std::string_view name, Clock::time_point begin, Clock::time_point end) {
    if (recorder_) recorder_->add_phase(name, step_, begin, end);
  }

 private:
  std::unique_ptr<Recorder> recorder_;
  std::int64_t step_ = -1;
};

/// That of this process.
Timeline& timeline();

/// Adds its own lifetime to the timeline as one phase.
class Span {
 public:
  /// @param name  a literal
  explicit Span(std::string_view name) : name_(name) {}
  Span(const Span&) = delete;
  Span& operator=(const Span&) = delete;
  ~Span() { timeline().add(name_, begin_, Clock::now()); }

 private:
  std::string_view name_;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace copepod::recording
