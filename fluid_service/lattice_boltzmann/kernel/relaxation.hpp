#pragma once

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/kernel/collision.hpp"

namespace copepod::fluid {

/// τ⁻ of the pair's antisymmetric half: τ⁻ − 1/2 = Λ / (τ − 1/2) with Λ = 3/16, which puts a half-way
/// bounce-back wall of a Poiseuille flow exactly half-way [Ginzburg, Verhaeghe, d'Humières 2008]; for BGK τ⁻
/// = τ.
template <class T>
CollisionConstants<T> collision_constants(CollisionKind kind, double relaxation_time,
                                          const Eigen::Vector3d& body_force_lu) {
  constexpr double magic = 3.0 / 16.0;
  const double odd_time =
      kind == CollisionKind::bgk ? relaxation_time : 0.5 + magic / (relaxation_time - 0.5);
  return {
      static_cast<T>(0.5 / relaxation_time),
      static_cast<T>(0.5 / odd_time),
      {static_cast<T>(body_force_lu[0]), static_cast<T>(body_force_lu[1]), static_cast<T>(body_force_lu[2])}};
}

}  // namespace copepod::fluid
