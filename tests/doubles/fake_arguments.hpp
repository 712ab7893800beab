#pragma once

#include <string>
#include <vector>

#include "halt.hpp"
#include "misbehaviour.hpp"

namespace copepod::doubles {

/// The command line of a fake: its own options are taken out, the rest is for the component kit.
class FakeArguments {
 public:
  FakeArguments(int argc, char** argv);

  [[nodiscard]] int argc() const { return static_cast<int>(texts_.size()); }
  [[nodiscard]] char** argv() { return pointers_.data(); }
  [[nodiscard]] const Misbehaviour& misbehaviour() const { return misbehaviour_; }
  [[nodiscard]] const Halt& halt() const { return halt_; }

 private:
  std::vector<std::string> texts_;
  std::vector<char*> pointers_;
  Misbehaviour misbehaviour_;
  Halt halt_;
};

}  // namespace copepod::doubles
