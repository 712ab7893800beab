#pragma once

#include <memory>

#include "lattice_boltzmann/lattice_boltzmann.hpp"

namespace copepod::fluid::validation {

/// A fluid in lattice units: cell, step and density are 1, so SI numbers are lattice numbers.
inline FluidSetup lattice_unit_setup(const Cell& cells, double viscosity, BoundaryKind boundary) {
  FluidSetup setup;
  setup.step_s = 1.0;
  setup.cell_size_m = 1.0;
  setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = viscosity;
  setup.domain_cells = cells;
  for (Boundary& face : setup.boundaries) face.kind = boundary;
  setup.collision = CollisionKind::trt;
  return setup;
}

inline void set_axis(FluidSetup& setup, int axis, BoundaryKind kind) {
  setup.boundaries[2 * axis].kind = kind;
  setup.boundaries[2 * axis + 1].kind = kind;
}

/// Bodies at rest at the given places.
inline Kinematics resting(const std::vector<Eigen::Vector3d>& positions) {
  Kinematics kinematics;
  kinematics.resize(static_cast<Eigen::Index>(positions.size()));
  for (std::size_t b = 0; b < positions.size(); ++b) {
    const auto column = static_cast<Eigen::Index>(b);
    kinematics.position_m.col(column) = positions[b];
    kinematics.orientation_wxyz.col(column) = Eigen::Vector4d(1, 0, 0, 0);
  }
  kinematics.velocity_m_per_s.setZero();
  kinematics.angular_velocity_rad_per_s.setZero();
  return kinematics;
}

/// One rank of lattice Boltzmann with the same kinematics in every step.
template <class T = double>
class FlowCase {
 public:
  explicit FlowCase(const FluidSetup& setup, Kinematics kinematics = resting({}))
      : solver_(setup, communicator_), kinematics_(std::move(kinematics)) {}

  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      kinematics_.step = solver_.step();
      solver_.exchange(kinematics_, loads_);
      solver_.advance();
    }
  }
  [[nodiscard]] LatticeBoltzmann<T>& solver() { return solver_; }
  [[nodiscard]] const LatticeBoltzmann<T>& solver() const { return solver_; }
  [[nodiscard]] const Loads& loads() const { return loads_; }
  [[nodiscard]] Kinematics& kinematics() { return kinematics_; }

 private:
  SolverContext context_;
  SelfCommunicator communicator_{context_};
  LatticeBoltzmann<T> solver_;
  Kinematics kinematics_;
  Loads loads_;
};

/// Index of a cell in a FieldBlock.
inline std::size_t field_index(const FieldBlock& block, std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::size_t>((x * block.box.extent(1) + y) * block.box.extent(2) + z);
}

}  // namespace copepod::fluid::validation
