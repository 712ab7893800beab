#include "scheme/lubrication.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

constexpr double viscosity_Pa_s = 0.5;
constexpr double radius_m = 10.0;
constexpr double roughness_m = 1e-9;

/// Cells of 1 m and films of 1.5 m between walls 100 m apart; the step is so short that films keep their thickness.
FluidSetup box(const std::vector<Shape>& bodies) {
  FluidSetup setup;
  setup.step_s = 1e-12;
  setup.cell_size_m = 1.0;
  setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = viscosity_Pa_s;
  setup.domain_cells = {100, 100, 100};
  setup.film_thickness_m = 1.5;
  setup.bodies = bodies;
  return setup;
}

const Shape sphere{ShapeKind::sphere, radius_m, 0.0};
const Shape capsule{ShapeKind::capsule, radius_m, 40.0};

/// Bodies in a box, and the loads of the films between them.
struct Bodies {
  explicit Bodies(const std::vector<Shape>& shapes, double mass_kg = 1e15) : fluid(box(shapes)), setup{} {
    kinematics.resize(static_cast<Eigen::Index>(shapes.size()));
    kinematics.position_m.setConstant(50.0);
    kinematics.velocity_m_per_s.setZero();
    kinematics.angular_velocity_rad_per_s.setZero();
    kinematics.orientation_wxyz.colwise() = Eigen::Vector4d(1, 0, 0, 0);
    setup.bodies.resize(shapes.size());
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      setup.bodies[i].shape = shapes[i];
      setup.bodies[i].mass_kg = mass_kg;
    }
  }

  [[nodiscard]] Loads loads() const {
    Loads none;
    none.resize(kinematics.bodies());
    none.force_N.setZero();
    none.torque_N_m.setZero();
    Lubrication lubrication(fluid, setup, roughness_m);
    const Loads* films = lubrication.loads(kinematics, none, none);
    return films == nullptr ? none : *films;
  }

  FluidSetup fluid;
  BodySetup setup;
  Kinematics kinematics;
};

/// A sphere at a thin gap from the wall z = 0.
Bodies at_the_wall(double gap_m) {
  Bodies bodies({sphere});
  bodies.kinematics.position_m(2, 0) = radius_m + gap_m;
  return bodies;
}

// What multiplies the logarithm is exact, so differences between two gaps hold no constant.
constexpr double gap_m = 1e-4;
const double decades = std::log(10.0);

double difference(double at_thin, double at_thick) { return at_thin - at_thick; }

TEST(Lubrication, HasNoFilmBetweenBodiesThatOverlapAtAJoint) {
  Bodies bodies({sphere, sphere, sphere});
  bodies.kinematics.position_m.row(2) << 31.0, 50.0 - gap_m, 70.0;
  bodies.kinematics.velocity_m_per_s(2, 2) = -1.0;
  bodies.fluid.jointed = {{0, 1}};
  const Loads loads = bodies.loads();
  EXPECT_EQ(loads.force_N.col(0).norm(), 0.0);
  EXPECT_GT(loads.force_N(2, 2), 0.0);
  EXPECT_EQ(loads.force_N(2, 1), -loads.force_N(2, 2)) << "the third sphere and the second have one";
}

TEST(Lubrication, OfASphereThatApproachesAWallIsBrenners) {
  // 1/ε + 1/5 ln 1/ε + 0.97 of 6π μ r u [Brenner 1961]
  Bodies bodies = at_the_wall(gap_m);
  bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -2);
  EXPECT_NEAR(
      bodies.loads().force_N(2, 0) / (6 * std::numbers::pi * viscosity_Pa_s * radius_m * 2.0) * (gap_m / radius_m), 1.0,
      1e-4);
  EXPECT_NEAR(bodies.loads().torque_N_m.norm(), 0.0, 1e-6);
}

TEST(Lubrication, OfASphereThatMovesAlongAWallIsThatOfGoldmanCoxAndBrenner) {
  // −8/15 ln ε and the torque −1/10 ln ε of 6π μ r u and 8π μ r² u [Goldman, Cox, Brenner 1967]
  Bodies thin = at_the_wall(gap_m), thick = at_the_wall(10 * gap_m);
  thin.kinematics.velocity_m_per_s.col(0) = thick.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(1, 0, 0);
  const double force_N = difference(thin.loads().force_N(0, 0), thick.loads().force_N(0, 0));
  const double torque_N_m = difference(thin.loads().torque_N_m(1, 0), thick.loads().torque_N_m(1, 0));
  EXPECT_NEAR(force_N / (6 * std::numbers::pi * viscosity_Pa_s * radius_m), -8.0 / 15.0 * decades, 1e-3);
  EXPECT_NEAR(torque_N_m / (8 * std::numbers::pi * viscosity_Pa_s * radius_m * radius_m), 0.1 * decades, 1e-3);
}

TEST(Lubrication, OfASphereThatTurnsAtAWallIsThatOfGoldmanCoxAndBrenner) {
  // 2/15 ln ε and −2/5 ln ε of 6π μ r² ω and 8π μ r³ ω
  Bodies thin = at_the_wall(gap_m), thick = at_the_wall(10 * gap_m);
  thin.kinematics.angular_velocity_rad_per_s.col(0) = thick.kinematics.angular_velocity_rad_per_s.col(0) =
      Eigen::Vector3d(0, 1, 0);
  const double force_N = difference(thin.loads().force_N(0, 0), thick.loads().force_N(0, 0));
  const double torque_N_m = difference(thin.loads().torque_N_m(1, 0), thick.loads().torque_N_m(1, 0));
  EXPECT_NEAR(force_N / (6 * std::numbers::pi * viscosity_Pa_s * radius_m * radius_m), 2.0 / 15.0 * decades, 1e-3);
  EXPECT_NEAR(torque_N_m / (8 * std::numbers::pi * viscosity_Pa_s * std::pow(radius_m, 3)), -0.4 * decades, 1e-3);
}

/// What the pressure −6/5 u·x μ/h² and the shear beside it exert in the part of a film between two spheres that the
/// fluid leaves out, by quadrature: force along x on the first, the upper one, and torque about y on it about the
/// contact. The surfaces slide with v along x, the first turns with w about y relative to the second.
Eigen::Vector2d exerted(double k1, double k2, double gap, double v, double w) {
  const double R = 1.0 / (k1 + k2), q = (k1 - k2) * R;
  const double u = -2.0 * R * w - q * v;  // 2 R n × Δω − q v
  constexpr int pieces = 20000;
  const double dh = (2.0 - gap) / pieces;
  double shear1 = 0.0, shear2 = 0.0, pressure = 0.0;  // the last by the curvature of the surface
  for (int i = 0; i < pieces; ++i) {
    const double h = gap + (i + 0.5) * dh;
    const double area = 2.0 * std::numbers::pi * R * dh * std::min(1.0, 2.0 - h);
    const double slope = -1.2 * u * viscosity_Pa_s * (1.0 / (h * h) - 2.0 * (h - gap) / (h * h * h));  // mean of dp/dx
    shear1 += area * (-viscosity_Pa_s * v / h - 0.5 * h * slope);
    shear2 += area * (viscosity_Pa_s * v / h - 0.5 * h * slope);
    pressure += area * 1.2 * u * viscosity_Pa_s * R * (h - gap) / (h * h);
  }
  if (k2 == 0.0) return {shear1 + pressure * k1, pressure};
  return {0.5 * (shear1 + k1 * pressure - shear2 - k2 * pressure), pressure};  // half the difference
}

TEST(Lubrication, OfSlidingAndTurningIsThatOfTheFilmsPressureAndShear) {
  constexpr double large_m = 1e4;  // fitted terms are smaller by cells per radius
  for (const double other_m : {0.0, 1e4, 3e4}) {
    for (const double gap : {0.01, 0.4, 0.9, 1.5}) {
      for (const auto& [v, w] : {std::pair(1.0, 0.0), std::pair(0.0, 1.0 / large_m)}) {
        std::vector<Shape> shapes{{ShapeKind::sphere, large_m, 0.0}};
        if (other_m > 0.0) shapes.push_back({ShapeKind::sphere, other_m, 0.0});
        Bodies bodies(shapes);
        bodies.fluid.domain_cells = {1000000, 1000000, 1000000};
        bodies.kinematics.position_m.setConstant(5e5);
        bodies.kinematics.position_m(2, 0) = large_m + gap + (other_m > 0.0 ? 5e5 + other_m : 0.0);
        bodies.kinematics.velocity_m_per_s(0, 0) = v + w * (large_m + 0.5 * gap);
        bodies.kinematics.angular_velocity_rad_per_s(1, 0) = w;
        const Eigen::Vector2d expected = exerted(1.0 / large_m, other_m > 0.0 ? 1.0 / other_m : 0.0, gap, v, w);
        const Loads loads = bodies.loads();
        const double shear = 2.0 * std::numbers::pi * viscosity_Pa_s * large_m * 1e-3;
        EXPECT_NEAR(loads.force_N(0, 0), expected[0], shear) << other_m << ' ' << gap << ' ' << v;
        EXPECT_NEAR(loads.torque_N_m(1, 0), expected[1] - large_m * expected[0], large_m * shear)
            << other_m << ' ' << gap << ' ' << v;
      }
    }
  }
}

/// Two spheres, the second of them above the first.
Bodies pair(double gap, double mass_kg = 1e15) {
  Bodies bodies({sphere, sphere}, mass_kg);
  bodies.kinematics.position_m(2, 1) += 2 * radius_m + gap;
  return bodies;
}

TEST(Lubrication, OfTwoSpheresIsThatOfJeffreyAndOnishi) {
  // approach at W: 6π μ r W (1/4ξ + 9/40 ln 1/ξ), ξ = h/r; past each other at v: 6π μ r v 1/6 ln 1/ξ
  Bodies thin = pair(gap_m), thick = pair(10 * gap_m);
  for (Bodies* bodies : {&thin, &thick}) bodies->kinematics.velocity_m_per_s.col(1) = Eigen::Vector3d(1, 0, -1);
  const double stokes = 6 * std::numbers::pi * viscosity_Pa_s * radius_m;
  const double approach_N = thin.loads().force_N(2, 1) - thick.loads().force_N(2, 1);
  EXPECT_NEAR(approach_N / stokes - radius_m / 4 * (1 / gap_m - 0.1 / gap_m), 9.0 / 40.0 * decades, 1e-3);
  EXPECT_NEAR((thin.loads().force_N(0, 1) - thick.loads().force_N(0, 1)) / stokes, -decades / 6.0, 1e-3);
}

TEST(Lubrication, OfAPairIsOppositeAndTurnsThePairAsAWholeByNothing) {
  Bodies bodies = pair(0.2);
  bodies.kinematics.position_m(0, 1) += 3.0;
  bodies.kinematics.position_m(2, 1) -= 0.3;
  bodies.kinematics.velocity_m_per_s.col(1) = Eigen::Vector3d(0.3, 1, -1);
  const Loads loads = bodies.loads();
  EXPECT_GT(loads.force_N.col(1).norm(), 10.0);
  EXPECT_NEAR((loads.force_N.col(0) + loads.force_N.col(1)).norm(), 0.0, 1e-9);
  const Eigen::Vector3d r = bodies.kinematics.position_m.col(1) - bodies.kinematics.position_m.col(0);
  EXPECT_NEAR((loads.torque_N_m.col(0) + loads.torque_N_m.col(1) + r.cross(loads.force_N.col(1))).norm(), 0.0, 1e-8);
}

TEST(Lubrication, OfAPairThatMovesTogetherIsNothing) {
  Bodies bodies = pair(0.1);
  const Eigen::Vector3d w(0.1, 0.2, -0.3);
  for (Eigen::Index i : {0, 1}) {
    bodies.kinematics.angular_velocity_rad_per_s.col(i) = w;
    bodies.kinematics.velocity_m_per_s.col(i) =
        Eigen::Vector3d(1, 2, 3) + w.cross(Eigen::Vector3d(bodies.kinematics.position_m.col(i)));
  }
  EXPECT_NEAR(bodies.loads().force_N.norm(), 0.0, 1e-9);
  EXPECT_NEAR(bodies.loads().torque_N_m.norm(), 0.0, 1e-8);
}

/// A row of spheres along z, 0.2 m apart, whose motion repeats itself after `period` of them.
Bodies row(std::size_t spheres, std::size_t period, double mass_kg = 1e15) {
  constexpr double spacing_m = 21.0;
  Bodies bodies(std::vector<Shape>(spheres, {ShapeKind::sphere, 0.5 * (spacing_m - 0.2), 0.0}), mass_kg);
  bodies.fluid.domain_cells[2] = static_cast<std::int64_t>(spacing_m) * static_cast<std::int64_t>(spheres);
  for (std::size_t i = 0; i < spheres; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double sign = i % period == 0 ? 1.0 : -0.7;
    bodies.kinematics.position_m(2, column) = spacing_m * (static_cast<double>(i) + 0.5);
    bodies.kinematics.velocity_m_per_s.col(column) = sign * Eigen::Vector3d(0.5, 0.2, -1);
    bodies.kinematics.angular_velocity_rad_per_s.col(column) = sign * Eigen::Vector3d(0.1, 0.2, 0.3);
  }
  return bodies;
}

Bodies periodic(Bodies bodies) {
  for (const std::size_t face : {4, 5}) bodies.fluid.boundaries[face].kind = BoundaryKind::periodic;
  return bodies;
}

TEST(Lubrication, ActsWithEveryPeriodicImage) {
  for (const std::size_t period : {1, 2, 3}) {  // its own images, both sides of one neighbour, a row
    const Loads expected = row(5 * period, period).loads(), found = periodic(row(period, period)).loads();
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(period); ++i) {
      const Eigen::Index middle = i + 2 * static_cast<Eigen::Index>(period);
      EXPECT_GT(expected.torque_N_m.col(middle).norm(), 1.0);
      EXPECT_LT((found.force_N.col(i) - expected.force_N.col(middle)).norm(), 1e-8) << period;
      EXPECT_LT((found.torque_N_m.col(i) - expected.torque_N_m.col(middle)).norm(), 1e-8) << period;
    }
  }
}

TEST(Lubrication, OfABodyWithItsOwnImagesStopsItWithoutTurningItBack) {
  Bodies bodies = periodic(row(1, 1, 1e-3));
  bodies.fluid.step_s = 1.0;
  const Loads loads = bodies.loads();
  const double inertia_kg_m2 = inertia_tensor_kg_m2(bodies.fluid.bodies[0], 1e-3)(2, 2);
  const Eigen::Vector3d stopped = -loads.torque_N_m.col(0) / inertia_kg_m2;
  EXPECT_LT(loads.force_N.norm(), 1e-9);
  for (const Eigen::Index across : {0, 1})
    EXPECT_NEAR(stopped[across] / bodies.kinematics.angular_velocity_rad_per_s(across, 0), 1.0, 1e-2);
  EXPECT_LT(stopped[0], bodies.kinematics.angular_velocity_rad_per_s(0, 0));
  EXPECT_NEAR(stopped[2], 0.0, 1e-9) << "images turn alike about the row";
}

TEST(Lubrication, WithAMirrorIsThatWithTheImage) {
  Bodies one({sphere}), two = pair(0.1);
  one.fluid.boundaries[4].kind = BoundaryKind::free_slip;
  one.kinematics.position_m(2, 0) = radius_m + 0.05;
  one.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0.5, 0, -1);
  // About the normal: of other turning the fluid leaves out all beside a mirror, but half between two bodies.
  one.kinematics.angular_velocity_rad_per_s.col(0) = Eigen::Vector3d(0, 0, 0.3);
  two.kinematics.velocity_m_per_s << 0.5, 0.5, 0, 0, 1, -1;
  two.kinematics.angular_velocity_rad_per_s << 0, 0, 0, 0, 0.3, 0.3;
  EXPECT_NEAR((one.loads().force_N.col(0) - two.loads().force_N.col(1)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((one.loads().torque_N_m.col(0) - two.loads().torque_N_m.col(1)).norm(), 0.0, 1e-8);
}

TEST(Lubrication, OfASphereThatMovesWithItsWallIsNothing) {
  Bodies bodies = at_the_wall(0.1);
  bodies.fluid.boundaries[4] = {.kind = BoundaryKind::velocity, .velocity_m_per_s = {1, 0, 0}};
  bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(1, 0, 0);
  EXPECT_EQ(bodies.loads().force_N.norm(), 0.0);
  bodies.fluid.boundaries[4].signal = {.kind = SignalKind::constant, .amplitude = 1.0, .ramp_steps = 10, .table = {}};
  bodies.kinematics.velocity_m_per_s.col(0) *= 0.35;  // in the middle of step 3
  bodies.kinematics.step = 3;
  EXPECT_EQ(bodies.loads().force_N.norm(), 0.0);
}

TEST(Lubrication, StopsABodyWithinAStepWithoutTurningItBack) {
  Bodies bodies = pair(1e-8, 2.0);
  bodies.fluid.step_s = 1e-3;
  bodies.kinematics.velocity_m_per_s.col(1) = Eigen::Vector3d(0, 0, -1);
  const double stopped_m_per_s = bodies.loads().force_N(2, 1) * bodies.fluid.step_s * (1 / 2.0 + 1 / 2.0);
  EXPECT_NEAR(stopped_m_per_s, 1.0, 1e-6);
  EXPECT_LT(stopped_m_per_s, 1.0);
}

TEST(Lubrication, LetsABodySinkAsItsWeightDemandsHoweverThinTheFilm) {
  for (const double mass_kg : {100.0, 1e-3}) {
    Bodies bodies = at_the_wall(1.0);
    bodies.setup.bodies[0].mass_kg = mass_kg;
    bodies.setup.gravity_m_per_s2 = {0, 0, -9.81};
    bodies.fluid.step_s = 1e-3;
    double velocity_m_per_s = 0.0;
    for (int i = 0; i < 20000; ++i) {  // at this gap
      bodies.kinematics.velocity_m_per_s(2, 0) = velocity_m_per_s;
      velocity_m_per_s += bodies.fluid.step_s * (bodies.loads().force_N(2, 0) / mass_kg - 9.81);
    }
    Bodies heavy = at_the_wall(1.0);
    heavy.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
    const double exact_m_per_s = -9.81 * mass_kg / heavy.loads().force_N(2, 0);
    EXPECT_NEAR(velocity_m_per_s / exact_m_per_s, 1.0, 1e-6) << mass_kg;
  }
}

TEST(Lubrication, StopsABodyBetweenTwoSurfacesWithoutTurningItBack) {
  Bodies bodies({sphere, sphere, sphere}, 2.0);
  bodies.fluid.step_s = 1e-3;
  for (const Eigen::Index i : {1, 2}) bodies.kinematics.position_m(2, i) += (i == 1 ? 1 : -1) * (2 * radius_m + 1e-8);
  for (const std::size_t i : {1, 2}) bodies.setup.bodies[i].motion = MotionKind::fixed;
  bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
  const double stopped_m_per_s = bodies.loads().force_N(2, 0) * bodies.fluid.step_s / 2.0;
  EXPECT_NEAR(stopped_m_per_s, 1.0, 1e-6);
  EXPECT_LT(stopped_m_per_s, 1.0 + 1e-12) << "by more than rounding";
}

/// Impulse of the film on a sphere that crosses it to or from the wall within a step, and whose velocity stays.
double impulse_N_s(double velocity_m_per_s, double roughness) {
  Bodies bodies = at_the_wall(velocity_m_per_s < 0.0 ? 0.1 : -0.01);
  bodies.setup.contact.stiffness_N_per_m = 1.0;
  bodies.fluid.step_s = 0.11 / std::abs(velocity_m_per_s);
  bodies.kinematics.velocity_m_per_s(2, 0) = velocity_m_per_s;
  Loads none;
  none.resize(1);
  none.force_N.setZero();
  none.torque_N_m.setZero();
  Lubrication lubrication(bodies.fluid, bodies.setup, roughness);
  return lubrication.loads(bodies.kinematics, none, none)->force_N(2, 0) * bodies.fluid.step_s;
}

TEST(Lubrication, TakesFromASphereThatCrossesAFilmWhatTheoryDemandsHoweverLongTheStep) {
  // ∫ 6π μ r² dh/h: ln 10 of it for each decade of roughness. A tenth of the thickness at a time gives 5 % less on the
  // way in and 5 % more on the way out.
  for (const double velocity_m_per_s : {-1.0, -1e3, 1.0, 1e3}) {
    const double of_a_decade_N_s = impulse_N_s(velocity_m_per_s, 1e-5) - impulse_N_s(velocity_m_per_s, 1e-4);
    const double exact_N_s = 6 * std::numbers::pi * viscosity_Pa_s * radius_m * radius_m * decades;
    EXPECT_NEAR(of_a_decade_N_s / exact_N_s, velocity_m_per_s < 0.0 ? 1.0 : -1.0, 0.06) << velocity_m_per_s;
  }
}

TEST(Lubrication, DoesNotResistTheApproachOfSurfacesInContact) {
  for (const bool resolved : {false, true}) {
    for (const double gap : {-gap_m, gap_m}) {
      Bodies bodies = pair(gap);
      bodies.setup.contact.stiffness_N_per_m = resolved ? 1.0 : 0.0;
      bodies.kinematics.velocity_m_per_s.col(1) = Eigen::Vector3d(1, 0, -1);
      const Loads loads = bodies.loads();
      EXPECT_EQ(loads.force_N(2, 1) > 0.0, !(resolved && gap < 0.0));
      EXPECT_LT(loads.force_N(0, 1), 0.0) << "they still slide on a film";
    }
  }
}

TEST(Lubrication, EndsContinuouslyAtTheCutOff) {
  for (const Eigen::Vector3d& velocity : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 0, 0)}) {
    Bodies bodies = at_the_wall(1.9999);
    bodies.kinematics.velocity_m_per_s.col(0) = velocity;
    const double just_within_N = bodies.loads().force_N.norm();
    EXPECT_GT(just_within_N, 0.0);
    EXPECT_LT(just_within_N, 1e-2);
    bodies.kinematics.position_m(2, 0) = radius_m + 2.0001;
    EXPECT_EQ(bodies.loads().force_N.norm(), 0.0);
  }
}

TEST(Lubrication, OfACapsuleAlongAWallIsThatOfACylinder) {
  // Per length of a cylinder that approaches a wall, 3√2 π μ W (r/h)^(3/2) [Jeffrey & Onishi, Q. J. Mech. Appl. Math.
  // 34, 1981]; the ends, which are those of a sphere, are thinner by √(h/r).
  Bodies bodies({capsule});
  const double turned = std::sqrt(0.5);
  bodies.kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(turned, 0, turned, 0);  // along x
  bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
  for (const double thin_m : {1e-3, 1e-5}) {
    bodies.kinematics.position_m(2, 0) = radius_m + thin_m;
    const double cylinder_N =
        3 * std::sqrt(2.0) * std::numbers::pi * viscosity_Pa_s * std::pow(radius_m / thin_m, 1.5) * capsule.length_m;
    const double ends_N = 6 * std::numbers::pi * viscosity_Pa_s * radius_m * radius_m / thin_m;
    EXPECT_NEAR(bodies.loads().force_N(2, 0) / (cylinder_N + ends_N), 1.0, 2e-3);
    EXPECT_NEAR(bodies.loads().torque_N_m.norm() / bodies.loads().force_N(2, 0), 0.0, 1e-6);
  }
}

TEST(Lubrication, OfACapsuleUprightOnAWallIsThatOfASphere) {
  Bodies upright({capsule}), ball = at_the_wall(0.01);
  upright.kinematics.position_m(2, 0) = 0.5 * capsule.length_m + radius_m + 0.01;
  for (Bodies* bodies : {&upright, &ball}) bodies->kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
  EXPECT_NEAR(upright.loads().force_N(2, 0) / ball.loads().force_N(2, 0), 1.0, 0.01);
}

TEST(Lubrication, OfCrossedCapsulesIsThatOfTheirCurvatures) {
  // 12π μ W / ((λ₁ + λ₂) √(λ₁λ₂) h) with λ = 1/r of both, crossed at a right angle: that of a sphere at a wall.
  Bodies crossed({capsule, capsule});
  const double thin_m = 1e-3;
  const double turned = std::sqrt(0.5);
  crossed.kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(turned, 0, turned, 0);  // along x
  crossed.kinematics.orientation_wxyz.col(1) = Eigen::Vector4d(turned, turned, 0, 0);  // along y
  crossed.kinematics.position_m(2, 1) += 2 * radius_m + thin_m;
  crossed.kinematics.velocity_m_per_s.col(1) = Eigen::Vector3d(0, 0, -1);
  const double force_N = 6 * std::numbers::pi * viscosity_Pa_s * radius_m * radius_m / thin_m;
  EXPECT_NEAR(crossed.loads().force_N(2, 1) / force_N, 1.0, 0.02);
  EXPECT_NEAR(crossed.loads().force_N(2, 0) / force_N, -1.0, 0.02);
}

TEST(Lubrication, OfACapsuleNearlyAlongAWallPushesItFlat) {
  Bodies bodies({capsule});
  const double angle = std::numbers::pi / 2 - 0.01;  // of 0.4 m over the length; the lower end is at positive x
  bodies.kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(std::cos(0.5 * angle), 0, std::sin(0.5 * angle), 0);
  bodies.kinematics.position_m(2, 0) = radius_m + 0.21;
  bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
  EXPECT_GT(std::abs(bodies.loads().torque_N_m(1, 0)), bodies.loads().force_N(2, 0));  // an arm of more than a metre
}

Shape ellipsoid(const Eigen::Vector3d& semi_axes_m) {
  return {.kind = ShapeKind::ellipsoid, .radius_m = std::cbrt(semi_axes_m.prod()), .extents_m = semi_axes_m};
}

TEST(Lubrication, OfAnEllipsoidWithEqualAxesIsThatOfASphere) {
  for (const bool is_pair : {false, true}) {
    std::vector<Loads> found;
    for (const Shape& shape : {sphere, ellipsoid({radius_m, radius_m, radius_m})}) {
      Bodies bodies(is_pair ? std::vector<Shape>{shape, sphere} : std::vector<Shape>{shape});
      bodies.kinematics.position_m(2, 0) = radius_m + 0.3;
      bodies.kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(0.8, 0.0, 0.6, 0.0);
      bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0.4, -0.2, -1.0);
      bodies.kinematics.angular_velocity_rad_per_s.col(0) = Eigen::Vector3d(0.01, 0.02, -0.03);
      if (is_pair) bodies.kinematics.position_m.col(1) = Eigen::Vector3d(50 + 12.0, 50 + 16.1, radius_m + 2.0);
      found.push_back(bodies.loads());
    }
    EXPECT_GT(found[0].force_N.norm(), 1.0);
    EXPECT_LT((found[1].force_N - found[0].force_N).norm(), 1e-9 * found[0].force_N.norm());
    EXPECT_LT((found[1].torque_N_m - found[0].torque_N_m).norm(), 1e-9 * found[0].torque_N_m.norm());
  }
}

TEST(Lubrication, OfEllipsoidsIsThatOfTheirCurvatures) {
  // 12π μ W / ((λ₁ + λ₂) √(λ₁λ₂) h), λ the principal curvatures of both surfaces together.
  const Eigen::Vector3d a(12, 8, 20);
  const Eigen::Vector2d of_one(a[2] / (a[0] * a[0]), a[2] / (a[1] * a[1]));  // at the end of the z axis
  const double turned = std::sqrt(0.5);                                      // a quarter about z
  const double thin_m = 1e-3;
  for (const auto& [partner, curvatures_per_m] :
       {std::pair<double, Eigen::Vector2d>{-1.0, of_one}, {1.0, 2.0 * of_one}, {turned, of_one + of_one.reverse()}}) {
    const bool at_wall = partner < 0.0;
    Bodies bodies(at_wall ? std::vector<Shape>{ellipsoid(a)} : std::vector<Shape>{ellipsoid(a), ellipsoid(a)});
    bodies.kinematics.position_m(2, 0) = at_wall ? a[2] + thin_m : 65.0;
    bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
    if (!at_wall) {
      bodies.kinematics.position_m(2, 1) = 65.0 - 2.0 * a[2] - thin_m;
      bodies.kinematics.orientation_wxyz.col(1) = Eigen::Vector4d(partner, 0, 0, std::sqrt(1.0 - partner * partner));
    }
    const double force_N =
        12 * std::numbers::pi * viscosity_Pa_s / (curvatures_per_m.sum() * std::sqrt(curvatures_per_m.prod()) * thin_m);
    EXPECT_NEAR(bodies.loads().force_N(2, 0) / force_N, 1.0, 0.02) << partner;
  }
}

/// What multiplies the logarithm of the gap [theory.md, (C20)], in both principal directions.
TEST(Lubrication, OfAnEllipsoidThatSlidesAndTurnsIsThatOfItsCurvatures) {
  const Eigen::Vector3d a(12, 8, 20);
  const Eigen::Array2d k(a[2] / (a[0] * a[0]), a[2] / (a[1] * a[1]));
  const Eigen::Array2d pressure = 3.0 * k / (3.0 * k + 2.0 * k.reverse());
  const double viscous = 2 * std::numbers::pi * viscosity_Pa_s / std::sqrt(k.prod()) * decades;
  const auto loads_at = [&](double gap, const Eigen::Vector3d& v, const Eigen::Vector3d& w) {
    Bodies bodies({ellipsoid(a)});
    bodies.kinematics.position_m(2, 0) = a[2] + gap;
    bodies.kinematics.velocity_m_per_s.col(0) = v;
    bodies.kinematics.angular_velocity_rad_per_s.col(0) = w;
    const Loads loads = bodies.loads();
    Eigen::Vector<double, 6> both;
    both << loads.force_N.col(0), loads.torque_N_m.col(0);
    return both;
  };
  const Eigen::Vector3d none(0, 0, 0);
  using Vector6 = Eigen::Vector<double, 6>;
  const auto per_decade = [&](const Eigen::Vector3d& v, const Eigen::Vector3d& w) {
    return Vector6((loads_at(gap_m, v, w) - loads_at(10 * gap_m, v, w)) / viscous);
  };
  for (const int i : {0, 1}) {
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(i), axis = Eigen::Vector3d::UnitZ().cross(along);
    const double coupling = 6.0 / (3.0 * k[i] + 2.0 * k[1 - i]);
    const Vector6 sliding = per_decade(along, none);
    EXPECT_NEAR(sliding[i], -1.0 - pressure[i], 0.002) << i;
    EXPECT_NEAR(sliding.tail<3>().dot(axis), -a[2] * sliding[i] - coupling, 0.01 * coupling) << i;
    // About the point on the wall, where v = 0.
    const Vector6 turning = per_decade(a[2] * axis.cross(Eigen::Vector3d::UnitZ()), axis);
    EXPECT_NEAR(turning[i], -coupling, 0.01 * coupling) << i;
    EXPECT_NEAR(turning.tail<3>().dot(axis), a[2] * coupling - 2.0 * coupling / k[i], 0.02 * a[2] * coupling) << i;
  }
  const auto squeezing = [&](double gap) { return loads_at(gap, {0, 0, -1}, none)[2]; };
  const double R = 2.0 / k.sum();
  const double series = (squeezing(gap_m) - squeezing(10 * gap_m)) / (3.0 * viscous / decades) - R * 0.9 / gap_m;
  EXPECT_NEAR(series / decades, 0.2 + 0.75 * (1.0 - R / a[2]), 0.01);
}

TEST(Lubrication, OfATiltedEllipsoidActsWhereItIsNearest) {
  Bodies bodies({ellipsoid({8, 8, 20})});
  const double tilt = 0.5;  // of the long axis towards x; the nearest point is the one with the normal −z
  const double height_m = std::hypot(8 * std::sin(tilt), 20 * std::cos(tilt));
  bodies.kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(std::cos(0.5 * tilt), 0, std::sin(0.5 * tilt), 0);
  bodies.kinematics.position_m(2, 0) = height_m + 1e-3;
  bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
  const double arm_m = (64.0 - 400.0) * std::sin(tilt) * std::cos(tilt) / height_m;  // along x
  const Loads loads = bodies.loads();
  EXPECT_NEAR(loads.torque_N_m(1, 0) / loads.force_N(2, 0), -arm_m, 0.01 * std::abs(arm_m));
  EXPECT_NEAR(loads.torque_N_m(0, 0), 0.0, 1e-6 * std::abs(loads.torque_N_m(1, 0)));
}

TEST(Lubrication, IsNothingWithoutFilms) {
  Bodies bodies = at_the_wall(0.1);
  bodies.fluid.film_thickness_m = 0.0;
  bodies.kinematics.velocity_m_per_s.col(0) = Eigen::Vector3d(0, 0, -1);
  EXPECT_EQ(bodies.loads().force_N.norm(), 0.0);
}

}  // namespace
}  // namespace copepod::coupler
