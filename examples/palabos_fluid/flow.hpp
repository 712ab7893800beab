#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

/// The flow in lattice units. Trivial, so that rank 0 can send it to the others as bytes.
struct FlowSetup {
  std::array<std::int64_t, 3> cells{};
  std::array<bool, 3> periodic{};
  std::array<std::array<double, 3>, 6> wall_velocity{};  ///< x low, x high, y low, …
  std::array<double, 3> body_force{};
  double omega = 1.0;
  bool two_relaxation_times = false;
};

struct BodyShape {
  double radius = 0.0;
  double half_length = 0.0;
};

struct BodyMotion {
  std::array<double, 3> position{};
  std::array<double, 4> orientation_wxyz{};
  std::array<double, 3> velocity{};
  std::array<double, 3> spin{};
};

struct BodyLoad {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

/// After MPI_Init, on all ranks.
void start_palabos();

/// Palabos' D3Q19 lattice with rigid bodies by its immersed boundary (multi-direct forcing). All calls are collective;
/// everything is in lattice units.
///
/// Forcing points fill each body. A step moves the momentum at point k, of volume w_k, to that of the body:
///   g_k = w_k (v_k − j(x_k)),   v_k = U + Ω × r_k,   repeated until the points agree with each other.
/// The fluid inside a body thus moves with it, and what it takes is no load on the body:
///   load = Σ_k w_k (v_k − v_k' − f) − g_k,   v' of the step before, f the body force per volume.
class PalabosFlow {
 public:
  PalabosFlow(const FlowSetup& setup, const std::vector<BodyShape>& shapes);
  ~PalabosFlow();

  /// Loads on bodies that move as given; complete on rank 0 only.
  std::vector<BodyLoad> force_bodies(const std::vector<BodyMotion>& motions);
  /// Applies the forces to the fluid, collides and streams.
  void advance();

  /// Palabos' own serialisation of the populations to one file.
  void save(const std::string& file) const;
  void restore(const std::string& file, const std::vector<BodyMotion>& previous);
  /// Motions of the last step, part of the state.
  [[nodiscard]] const std::vector<BodyMotion>& previous() const { return previous_; }

  /// Digest of the populations of all fluid cells and of `previous()`; does not depend on the number of ranks.
  [[nodiscard]] std::uint64_t digest() const;

 private:
  struct Lattice;
  std::unique_ptr<Lattice> lattice_;
  std::vector<BodyMotion> previous_;
};
