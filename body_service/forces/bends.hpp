#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "forces/force_element.hpp"

namespace copepod::body {

/// All bends of a case: angular springs that keep the angle θ at body B between its arms a = p_A − p_B and
/// c = p_C − p_B near the rest angle,
///   E = κ (θ − θ₀)²/2,   F_A = κ (θ − θ₀) t_a/|a|,   F_C = κ (θ − θ₀) t_c/|c|,   F_B = −F_A − F_C          (B19)
/// with the unit vectors t_a and t_c across the arms, in their plane, towards the other arm.
class Bends final : public ForceElement {
 public:
  /// @throws CaseError if a bend joins bodies that do not exist or are not three, has a negative stiffness, or a rest
  ///         angle outside [0, π]
  explicit Bends(const BodySetup& setup);

  /// @throws SolverError naming the bodies if two of them coincide, or if their arms are parallel and the rest angle
  ///         is another one (the forces have no direction)
  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const override;

 private:
  [[noreturn]] void fail(const BendSpecification& bend) const;

  std::vector<BendSpecification> bends_;
  std::vector<std::string> names_;  ///< of the bodies, for errors
};

}  // namespace copepod::body
