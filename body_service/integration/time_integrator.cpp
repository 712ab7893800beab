#include "integration/time_integrator.hpp"

#include "contract/errors.hpp"
#include "integration/runge_kutta_4.hpp"
#include "integration/semi_implicit_euler.hpp"

namespace copepod::body {

std::unique_ptr<TimeIntegrator> make_time_integrator(Integrator kind, EquationsOfMotion& equations,
                                                     double step_s) {
  switch (kind) {
    case Integrator::semi_implicit_euler:
      return std::make_unique<SemiImplicitEuler>(equations, step_s);
    case Integrator::runge_kutta_4:
      return std::make_unique<RungeKutta4>(equations, step_s);
  }
  throw CaseError(
      "unknown integrator (the setup holds no valid value). Use semi_implicit_euler or runge_kutta_4.");
}

}  // namespace copepod::body
