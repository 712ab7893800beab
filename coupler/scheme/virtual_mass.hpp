#pragma once

#include <vector>

#include <Eigen/Core>

#include "config/sections/case.hpp"
#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"

namespace copepod::coupler {

/// Mass and inertia by which the coupling enlarges light bodies, and the loads that make up for them one step later, so
/// that every body component computes the motion of the true masses:
///   (M + m)(V(n+1) − V(n)) = Δt F̄(n) + p(n) − p(n−1),   p = m V
///   L'(n+1) − L'(n) = Δt T̄(n) + h(n) − h(n−1),   L' = R (I + J) Rᵀ ω,   h = R J Rᵀ ω          [docs/theory.md, (C19)]
/// It is distributed like that of the body, J = I m/M. Their weight stays that of M. What is kept, p = h = 0, makes the
/// step of the drag implicit: bodies lose their momentum over a few steps, however short the time they need for it.
class VirtualMass {
 public:
  /// No body has one.
  VirtualMass() = default;

  /// @param setup      the true bodies
  /// @param mass_kg    virtual mass m of each body; 0: none
  /// @param averaging  of the loads of bodies with a virtual mass; none: F̄(n) = F(n), even where those of other bodies
  ///                   are averaged
  /// @param returns    whether loads make up for them
  VirtualMass(const BodySetup& setup, const std::vector<double>& mass_kg, LoadAveraging averaging, bool returns = true);

  /// The setup to send to the body component: with masses M + m.
  [[nodiscard]] BodySetup enlarged(BodySetup setup) const;

  /// Bodies whose loads are not to be averaged, ascending.
  [[nodiscard]] const std::vector<Eigen::Index>& not_averaged() const { return not_averaged_; }

  /// Adds what the virtual masses gave to the fluid's loads, (p(n) − p(n−1))/Δt − m g and (h(n) − h(n−1))/Δt.
  /// In the first step p(n−1) = p(n).
  /// @param kinematics  of step n; steps must come in order
  /// @param loads       of that step
  void add_to(Loads& loads, const Kinematics& kinematics);

  /// Whether it has a state, the kinematics of the step before.
  [[nodiscard]] bool remembers() const { return returns_ && !additions_.empty(); }

  /// Kinematics of the step before, all that is needed to continue bit for bit; no bodies: none yet, or none needed.
  [[nodiscard]] const Kinematics& previous() const { return previous_; }
  void restore(const Kinematics& previous) { previous_ = previous; }

 private:
  struct Addition {
    Eigen::Index body = 0;
    double mass_kg = 0.0;
    Eigen::Matrix3d inertia_kg_m2;  ///< J in the frame of the body
    Eigen::Vector3d weight_N;       ///< m g
  };

  std::vector<Addition> additions_;
  std::vector<Eigen::Index> not_averaged_;
  double step_s_ = 0.0;
  bool returns_ = true;
  Kinematics previous_;
};

}  // namespace copepod::coupler
