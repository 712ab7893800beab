#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "analysis/cycle_observer.hpp"

namespace copepod::coupler {

inline constexpr double pi = std::numbers::pi;
inline constexpr std::int64_t period = 400;
inline constexpr double cell_m = 1e-6;
inline constexpr double step_s = 7.5e-10;

inline Swimmer three_spheres() {
  Swimmer swimmer;
  swimmer.name = "swimmer";
  Bead bead;
  bead.shape = {ShapeKind::sphere, 4 * cell_m, 0.0};
  bead.mass_kg = 5.44e-13;
  swimmer.beads = {bead, bead, bead};
  for (std::size_t i = 0; i < 3; ++i) {
    swimmer.beads[i].name = std::array{"B2", "B1", "B3"}[i];
    swimmer.beads[i].position_m.z() = (static_cast<double>(i) - 1.0) * 16 * cell_m;
  }
  swimmer.three_beads = ThreeBeads{{8 * cell_m, 8 * cell_m}, {1e-5, period, period / 4, 3}};
  for (int i = 0; i < 2; ++i) {
    Arm& arm = swimmer.arms.emplace_back();
    arm.body_A = i;
    arm.body_B = i + 1;
    Signal& signal = arm.drive.emplace().signal;
    signal.kind = SignalKind::sinusoid;
    signal.period_steps = period;
    signal.start_step = i * period / 4;
    signal.stop_step = 3 * period + i * period / 4;
  }
  return swimmer;
}

inline Case case_of(const Swimmer& swimmer) {
  Case the_case;
  the_case.fluid.density_kg_per_m3 = 1360;
  the_case.fluid.kinematic_viscosity_m2_per_s = 7.36e-5;
  the_case.fluid.cell_size_m = cell_m;
  the_case.step_s = step_s;
  the_case.swimmers = {swimmer};
  return the_case;
}

inline std::vector<Group> groups_of(const Case& the_case) { return groups_of(the_case, assemble(the_case)); }

/// A made-up swimmer whose arms follow l̄ + d cos(ωt + φ) exactly, whose middle bead drifts at a steady speed along the
/// own axis, and which turns about `spin_axis` through its middle bead.
struct MadeUpMotion {
  double drift_cells_per_step = 1e-4;
  std::array<double, 2> mean{16.2, 15.9};
  std::array<double, 2> amplitude{2.5, 3.8};
  std::array<double, 2> phase{0.7, -0.6};
  double turn_rad_per_step = 0.0;
  Eigen::Vector3d spin_axis = Eigen::Vector3d::UnitX();

  [[nodiscard]] double arm(std::size_t i, double t) const {
    return mean[i] + amplitude[i] * std::cos(2 * pi * t / period + phase[i]);
  }
  [[nodiscard]] double arm_rate(std::size_t i, double t) const {
    return -amplitude[i] * 2 * pi / period * std::sin(2 * pi * t / period + phase[i]);
  }
  [[nodiscard]] Eigen::Matrix3d rotation(double t) const {
    return Eigen::AngleAxisd(turn_rad_per_step * t, spin_axis).toRotationMatrix();
  }
  [[nodiscard]] Kinematics at(std::int64_t step) const {
    const auto t = static_cast<double>(step);
    const double middle = drift_cells_per_step * t;
    Kinematics state;
    state.step = step;
    state.resize(3);
    state.position_m.setZero();
    state.position_m.row(2) << (middle - arm(0, t)) * cell_m, middle * cell_m, (middle + arm(1, t)) * cell_m;
    state.position_m = (rotation(t) * state.position_m).eval().array() + 50 * cell_m;
    state.velocity_m_per_s.setZero();
    state.velocity_m_per_s.row(2) << drift_cells_per_step - arm_rate(0, t), drift_cells_per_step,
        drift_cells_per_step + arm_rate(1, t);
    state.velocity_m_per_s *= cell_m / step_s;
    state.angular_velocity_rad_per_s.setConstant(3, 3, 7.0);
    return state;
  }
};

inline Loads constant_forces(double trailing, double middle, double leading) {
  Loads drive;
  drive.force_N.setZero(3, 3);
  drive.torque_N_m.setZero(3, 3);
  drive.force_N.row(2) << trailing, middle, leading;
  return drive;
}

inline Loads loads(const Eigen::Vector3d& force_N, const Eigen::Vector3d& torque_N_m) {
  Loads loads;
  loads.resize(3);
  loads.force_N.colwise() = force_N;
  loads.torque_N_m.colwise() = torque_N_m;
  return loads;
}

inline void play(CycleObserver& observer, const MadeUpMotion& motion, const Loads& driving, std::int64_t stop,
                 std::int64_t start = 0, const Loads& applied = loads({0, 0, 0}, {0, 0, 0})) {
  for (std::int64_t step = start; step < stop; ++step)
    observer.observe({step, motion.at(step), applied, applied, driving, applied});
}

inline void finish(CycleObserver& observer, const MadeUpMotion& motion, const Loads& driving, std::int64_t step) {
  const Loads applied = loads({0, 0, 0}, {0, 0, 0});
  observer.finish({step, motion.at(step), applied, applied, driving, applied});
}

}  // namespace copepod::coupler
