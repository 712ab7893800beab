#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>

#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "contract/controller.hpp"
#include "contract/errors.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"

namespace copepod::coupler {

/// The components of a run, wherever they are.
///
/// Legal call order: connect -> fluid_capabilities, body_capabilities -> make_fluid, make_body -> finish;
/// stay_in_touch_during once connected; abort from anywhere. Solvers must not outlive this object.
class Components {
 public:
  Components() = default;
  Components(const Components&) = delete;
  Components& operator=(const Components&) = delete;
  virtual ~Components() = default;

  virtual void connect() = 0;
  [[nodiscard]] virtual const Capabilities& fluid_capabilities() const = 0;
  [[nodiscard]] virtual const Capabilities& body_capabilities() const = 0;
  virtual std::unique_ptr<FluidSolver> make_fluid(const FluidSetup& setup, std::int64_t first_step) = 0;
  virtual std::unique_ptr<BodySolver> make_body(const BodySetup& setup, std::int64_t first_step) = 0;
  /// By the controller's place in the case; only components in processes of their own have any.
  [[nodiscard]] virtual const Capabilities& controller_capabilities(std::size_t /*number*/) const { no_controllers(); }
  virtual std::unique_ptr<Controller> make_controller(std::size_t /*number*/, const ControllerSetup& /*setup*/,
                                                      std::int64_t /*first_step*/) {
    no_controllers();
  }
  virtual void finish() = 0;

  /// Runs work that takes the coupler long, or none; remote components receive heartbeats meanwhile.
  virtual void stay_in_touch_during(const std::function<void()>& work) { work(); }

  virtual void abort(const FailureReport& report) noexcept = 0;

 private:
  [[noreturn]] static void no_controllers() { throw std::logic_error("these components have no controllers"); }
};

}  // namespace copepod::coupler
