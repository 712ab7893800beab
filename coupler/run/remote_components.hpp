#pragma once

#include <optional>
#include <string>

#include "config/sections/case.hpp"
#include "remote/link.hpp"
#include "run/command_line.hpp"
#include "run/components.hpp"

namespace copepod::coupler {

/// Components in processes of their own, reached over the wire.
class RemoteComponents final : public Components {
 public:
  /// @param options      where they connect, with what token and keys, and where to record messages
  /// @param stop_signal  non-zero ends every wait; must outlive this object
  RemoteComponents(const Options& options, const ServicesCase& services, const std::atomic<int>& stop_signal);

  void connect() override;
  [[nodiscard]] const Capabilities& fluid_capabilities() const override {
    return link_->fluid_capabilities();
  }
  [[nodiscard]] const Capabilities& body_capabilities() const override { return link_->body_capabilities(); }
  std::unique_ptr<FluidSolver> make_fluid(const FluidSetup& setup, std::int64_t first_step) override;
  std::unique_ptr<BodySolver> make_body(const BodySetup& setup, std::int64_t first_step) override;
  void finish() override { link_->finish(); }
  void stay_in_touch_during(const std::function<void()>& work) override;
  void abort(const FailureReport& report) noexcept override;

 private:
  LinkSettings settings_;
  std::optional<Link> link_;  ///< after connect: binding may fail, and that is a failure of the run
};

}  // namespace copepod::coupler
