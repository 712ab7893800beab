// The paper's swimmer in vacuum against the exact solution (paper, Fig. positionPlot; its parameters are in
// the caption).

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double cell_m = 1e-6;
constexpr double period_steps = 28116;
constexpr double delay_steps = 7029;
constexpr double amplitude_N = 1e-5;
constexpr int cycles = 5;

double step_s() { return 2.0 * std::numbers::pi / (296057.86703 * period_steps); }

struct ReferenceRow {
  std::int64_t step;
  std::array<double, 3> z_cells;
  std::array<double, 3> v_cells_per_step;
};

std::vector<ReferenceRow> read_reference() {
  std::ifstream file(COPEPOD_REFERENCE_DIR "/vacuum_trajectory.csv");
  std::string line;
  std::getline(file, line);
  std::vector<ReferenceRow> rows;
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    ReferenceRow row{};
    numbers >> row.step;
    for (double& z : row.z_cells) numbers >> z;
    for (double& v : row.v_cells_per_step) numbers >> v;
    rows.push_back(row);
  }
  return rows;
}

/// Stroke force at a time that counts from the stroke's own start.
double stroke_N(double steps_since_start) {
  if (steps_since_start < 0.0 || steps_since_start > cycles * period_steps) return 0.0;
  return amplitude_N * std::sin(2.0 * std::numbers::pi * steps_since_start / period_steps);
}

/// Beads in the order B2 (trailing), B1 (middle), B3 (leading), as in the reference.
BodySetup swimmer(Integrator integrator) {
  BodySetup setup =
      setup_of({bead("B2", {0, 0, 25 * cell_m}), bead("B1", {0, 0, 50 * cell_m}), bead("B3", {0, 0, 75 * cell_m})},
               step_s(), integrator);
  for (const int trailing : {0, 1}) {
    SpringSpecification spring;
    spring.body_A = trailing;
    spring.body_B = trailing + 1;
    spring.stiffness_N_per_m = 1.72965;
    spring.damping_N_s_per_m = 1.57237e-7;
    spring.rest_length_m = 25 * cell_m;
    setup.springs.push_back(spring);
    setup.actuators.push_back(pair_force(trailing, trailing + 1));
  }
  return setup;
}

struct LargestErrors {
  double position = 0.0;  ///< relative to the position
  double velocity = 0.0;  ///< relative to the largest velocity of the reference
};

LargestErrors errors_against_reference(Integrator integrator) {
  RigidBodySolver solver(swimmer(integrator));
  const auto nodes = solver.driving_nodes();
  const auto reference = read_reference();
  EXPECT_EQ(reference.size(), 197U);
  double velocity_scale = 0.0;
  for (const auto& row : reference) {
    for (const double v : row.v_cells_per_step) velocity_scale = std::max(velocity_scale, std::abs(v));
  }

  LargestErrors errors;
  std::int64_t reached = 0;
  for (const auto& row : reference) {
    const auto drive = [&nodes](AppliedLoads& applied) {
      for (std::size_t node = 0; node < nodes.size(); ++node) {
        const double t = static_cast<double>(applied.hydrodynamic.step) + nodes[node];
        applied.actuation.col(static_cast<Eigen::Index>(node)) << stroke_N(t), stroke_N(t - delay_steps);
      }
    };
    const Kinematics state = advance(solver, row.step - reached, drive, 2);
    reached = row.step;
    for (int bead = 0; bead < 3; ++bead) {
      const double z = state.position_m(2, bead) / cell_m;
      const double v = state.velocity_m_per_s(2, bead) * step_s() / cell_m;
      errors.position = std::max(errors.position, std::abs(z - row.z_cells[bead]) / std::abs(row.z_cells[bead]));
      errors.velocity = std::max(errors.velocity, std::abs(v - row.v_cells_per_step[bead]) / velocity_scale);
    }
    EXPECT_TRUE(state.position_m.topRows(2).isZero(0.0)) << "off the axis at step " << row.step;
  }
  return errors;
}

TEST(VacuumSwimmer, AgreesWithTheExactSolutionToTenDigitsWithRungeKutta4) {
  const LargestErrors errors = errors_against_reference(Integrator::runge_kutta_4);
  RecordProperty("position_error", std::to_string(errors.position * 1e10) + "e-10");
  RecordProperty("velocity_error", std::to_string(errors.velocity * 1e10) + "e-10");
  EXPECT_LT(errors.position, 1e-12);  // ten digits are 5e-11; measured 1.2e-13
  EXPECT_LT(errors.velocity, 4e-12);  // measured 3.9e-13
}

TEST(VacuumSwimmer, IsOffByItsFirstOrderWithSemiImplicitEuler) {
  const LargestErrors errors = errors_against_reference(Integrator::semi_implicit_euler);
  RecordProperty("position_error", std::to_string(errors.position * 1e5) + "e-5");
  EXPECT_LT(errors.position, 5e-5);
  EXPECT_GT(errors.position, 5e-7);  // measured 6.1e-6
}

}  // namespace
}  // namespace copepod::body
