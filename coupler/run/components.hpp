#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"
#include "contract/capabilities.hpp"
#include "contract/errors.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"

namespace copepod::coupler {

/// The two components of a run, wherever they are.
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
  virtual void finish() = 0;

  /// Runs work that takes the coupler long; remote components receive heartbeats meanwhile.
  virtual void stay_in_touch_during(const std::function<void()>& work) { work(); }

  virtual void abort(const FailureReport& report) noexcept = 0;
};

}  // namespace copepod::coupler
