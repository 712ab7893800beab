#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

/// The flow in lattice units; numbers only, so that rank 0 can send it to the others.
struct FlowSetup {
  std::array<double, 3> cells, periodic, body_force;
  std::array<std::array<double, 3>, 6> wall_velocity;  ///< x low, x high, y low, …
  double omega, two_relaxation_times;
};

struct BodyShape {
  double radius, half_length;  ///< half the length of the cylinder of a capsule; 0 for a sphere
};

/// One column per body: position, orientation (w, x, y, z), velocity, angular velocity; or force and torque.
using Motions = Eigen::Matrix<double, 13, Eigen::Dynamic>;
using BodyLoads = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Palabos' D3Q19 lattice with rigid bodies by its immersed boundary (multi-direct forcing). All calls are collective;
/// everything is in lattice units.
///
/// Forcing points fill each body. A step moves the momentum at point k, of volume w_k, to that of the body:
///   g_k = w_k (v_k − j(x_k)),   v_k = U + Ω × r_k,   repeated until the points agree with each other.
/// The fluid inside a body thus moves with it, and what that takes does not belong to the load on the body:
///   load = Σ_k w_k (v_k − v_k' − f) − g_k,   v' of the step before, f the body force per volume.
class PalabosFlow {
 public:
  PalabosFlow(const FlowSetup& setup, const std::vector<BodyShape>& shapes);
  ~PalabosFlow();

  /// Loads on bodies that move as given; complete on rank 0 only.
  BodyLoads force_bodies(const Motions& motions);
  /// Applies the forces to the fluid, collides and streams.
  void advance();

  /// Palabos' own serialisation of the populations to one file; `previous()` is the rest of the state.
  void save(const std::string& file) const;
  void restore(const std::string& file, const Motions& previous);
  [[nodiscard]] const Motions& previous() const { return previous_; }  ///< motions of the last step

  /// Digest of the state; does not depend on the number of ranks.
  [[nodiscard]] std::uint64_t digest() const;

 private:
  struct Lattice;
  std::unique_ptr<Lattice> lattice_;
  Motions previous_;
};
