#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

/// Kinetic energy of a periodic block (density 1).
double kinetic_energy(const FieldBlock& fields) {
  double energy = 0.0;
  for (const double u : fields.velocity_m_per_s) energy += 0.5 * u * u;
  return energy;
}

/// Relative error of the viscosity that the decay of a Taylor-Green vortex shows:
///   u = U (cos kx sin ky, −sin kx cos ky), E(t) = E(0) exp(−4 ν k² t), p = −U²/4 (cos 2kx + cos 2ky).
/// Diffusive scaling: velocity and step shrink with the cell, so the error must fall with its square.
double viscosity_error(int cells) {
  const double viscosity = 1.0 / 18.0;  // the paper's, τ = 2/3
  const double k = 2.0 * std::numbers::pi / cells;
  const double speed = 0.64 / cells;
  FlowCase flow(lattice_unit_setup({cells, cells, 1}, viscosity, BoundaryKind::periodic));
  flow.solver().initialise([&](const Cell& cell, double(&u)[3]) {
    const double x = k * (static_cast<double>(cell[0]) + 0.5);
    const double y = k * (static_cast<double>(cell[1]) + 0.5);
    u[0] = speed * std::cos(x) * std::sin(y);
    u[1] = -speed * std::sin(x) * std::cos(y);
    u[2] = 0.0;
    return -0.75 * speed * speed * (std::cos(2.0 * x) + std::cos(2.0 * y));
  });
  const int quarter_life = cells * cells / 8;
  flow.run(quarter_life);  // past the initial layer
  const double before = kinetic_energy(flow.solver().fields());
  flow.run(2 * quarter_life);
  const double after = kinetic_energy(flow.solver().fields());
  const double measured = std::log(before / after) / (4.0 * k * k * 2.0 * quarter_life);
  return std::abs(measured / viscosity - 1.0);
}

TEST(TaylorGreen, ViscosityIsRightWithinOnePerMilleAndConvergesWithSecondOrder) {
  const double coarse = viscosity_error(16);
  const double medium = viscosity_error(32);
  const double fine = viscosity_error(64);
  RecordProperty("error_16", std::to_string(coarse));
  RecordProperty("error_64", std::to_string(fine));
  EXPECT_LT(fine, 1e-3);
  EXPECT_NEAR(std::log2(coarse / medium), 2.0, 0.3) << coarse << ' ' << medium << ' ' << fine;
  EXPECT_NEAR(std::log2(medium / fine), 2.0, 0.3) << coarse << ' ' << medium << ' ' << fine;
}

}  // namespace
}  // namespace copepod::fluid::validation
