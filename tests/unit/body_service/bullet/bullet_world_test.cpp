#include "bullet/bullet_world.hpp"

#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "engine/engine_under_test.hpp"
#include "geometry/contact_time.hpp"
#include "geometry/rotation.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {

MakeEngineWorld engine_under_test() { return make_bullet_world; }

namespace {

TEST(BulletWorld, LeavesFixedAndPrescribedBodiesTheirMotion) {
  BodySpecification fixed = bead("fixed", {0, 0, 0});
  fixed.motion = MotionKind::fixed;
  BodySpecification belt = bead("belt", {20e-6, 0, 0});
  belt.motion = MotionKind::prescribed;
  belt.velocity_m_per_s = {0, 0, 0.5};
  belt.angular_velocity_rad_per_s = {0, 1e5, 0};
  const auto load = [](AppliedLoads& applied) { applied.hydrodynamic.force_N.setConstant(1e-3); };
  EngineBodySolver bullet = engine_solver(setup_of({fixed, belt}, 7.5e-10));
  RigidBodySolver own(setup_of({fixed, belt}, 7.5e-10, Integrator::semi_implicit_euler));
  const Kinematics theirs = advance(bullet, 1000, load);
  const Kinematics ours = advance(own, 1000, load);
  EXPECT_EQ(theirs.position_m, ours.position_m);
  EXPECT_EQ(theirs.velocity_m_per_s, ours.velocity_m_per_s);
  EXPECT_LT((theirs.orientation_wxyz - ours.orientation_wxyz).norm(), 1e-13);
}

// Coulomb: the impulse along the wall is μ times that across it while the surfaces slide.
TEST(BulletWorld, SlidesAlongWallsByCoulombsLaw) {
  for (const double between_bodies : {0.5, 0.0}) {
    BodySetup setup = setup_of({bead("thrown", {0, 0, 5e-6})}, 1e-8);
    setup.bodies[0].velocity_m_per_s = {3, 0, -1};
    setup.contact = {stiffness_of_contact(4e-7, largest_inverse_mass_per_kg(setup.bodies)), 1.0, between_bodies};
    setup.walls = {{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}, 0.2}};
    EngineBodySolver bullet = engine_solver(setup);
    const Kinematics after = advance(bullet, 500);
    EXPECT_NEAR(after.velocity_m_per_s(0, 0), 3.0 - 0.2 * 2.0, 0.01);
    EXPECT_NEAR(after.angular_velocity_rad_per_s(1, 0), 2.5 * 0.4 / 4e-6, 0.02 * 2.5 * 0.4 / 4e-6);
  }
}

/// A capsule above a floor.
BodySetup falling_capsule(double tilt_rad, double height_m) {
  BodySetup setup = setup_of({capsule("thrown", {0, 0, height_m})}, 1e-8);
  setup.bodies[0].orientation_wxyz = rotated({0, tilt_rad, 0}, {1, 0, 0, 0});
  setup.bodies[0].velocity_m_per_s = {0, 0, -1};
  setup.contact = {stiffness_of_contact(4e-7, largest_inverse_mass_per_kg(setup.bodies)), 0.8, 0.0};
  setup.walls = {{{0, 0, 0}, {0, 0, 1}}};
  return setup;
}

TEST(BulletWorld, LetsACapsuleThatFallsFlatReboundWithBothEnds) {
  EngineBodySolver bullet = engine_solver(falling_capsule(0.5 * std::numbers::pi, 4.2e-6));
  const Kinematics after = advance(bullet, 100);
  EXPECT_NEAR(after.velocity_m_per_s(2, 0), 0.8, 0.001);
  EXPECT_LT(after.angular_velocity_rad_per_s.norm(), 1e-6 * 0.8 / 4e-6);
}

TEST(BulletWorld, LetsASlantedMeshRestOnItsSide) {
  const BodySetup setup = falling(shaped("slanted", {0, 0, 2.2e-6}, slanted_box({8e-6, 6e-6, 4e-6}, 0.5)));
  EngineBodySolver bullet = engine_solver(setup);
  const Kinematics rest = advance(bullet, 3000);
  EXPECT_NEAR(rest.position_m(2, 0), 2e-6, 4e-9);
  EXPECT_LT((rest.orientation_wxyz.col(0) - Eigen::Vector4d(1, 0, 0, 0)).norm(), 1e-3);
}

// Off the line of their centres, so that they turn.
TEST(BulletWorld, KeepsMomentumAndEnergyWhereOtherShapesCollide) {
  for (const Shape& shape : {ellipsoid({4e-6, 3e-6, 6e-6}), box({8e-6, 6e-6, 5e-6}), cylinder(4e-6, 7e-6), dumbbell(),
                             slanted_box({8e-6, 6e-6, 7e-6}, 0.3)}) {
    BodySetup setup = setup_of({shaped("a", {0, 0, 0}, shape), shaped("b", {13e-6, 1e-6, 2e-6}, shape)}, 1e-9);
    setup.bodies[0].velocity_m_per_s = {3, 0, 0};
    setup.bodies[1].orientation_wxyz = Eigen::Vector4d(0.8, 0.3, -0.4, 0.2).normalized();
    setup.contact = {stiffness_of_contact(4e-7, largest_inverse_mass_per_kg(setup.bodies)), 1.0, 0.0};
    EngineBodySolver bullet = engine_solver(setup);
    const auto sums = [&](const Kinematics& state) {
      Eigen::Matrix<double, 7, 1> sum = Eigen::Matrix<double, 7, 1>::Zero();
      for (const Eigen::Index i : {0, 1}) {
        const BodySpecification& body = setup.bodies[static_cast<std::size_t>(i)];
        const Eigen::Matrix3d R = rotation_matrix(state.orientation_wxyz.col(i));
        const Eigen::Vector3d v = state.velocity_m_per_s.col(i), w = state.angular_velocity_rad_per_s.col(i);
        const Eigen::Vector3d spin = R * inertia_tensor_kg_m2(body) * R.transpose() * w;
        const Eigen::Vector3d x = state.position_m.col(i);
        sum.head<3>() += v / 3.0;
        sum.segment<3>(3) += (x.cross(v) + spin / body.mass_kg) / (3.0 * 4e-6);
        sum[6] += (v.squaredNorm() + w.dot(spin) / body.mass_kg) / 9.0;
      }
      return sum;
    };
    Kinematics start;
    bullet.kinematics(start);
    const Kinematics end = advance(bullet, 5000);
    EXPECT_GT(end.velocity_m_per_s.col(1).norm(), 0.3) << name_of(shape_names, shape.kind);
    EXPECT_GT(end.angular_velocity_rad_per_s.col(1).norm(), 1e4);
    EXPECT_LT((sums(end) - sums(start)).head<6>().norm(), 5e-3) << name_of(shape_names, shape.kind);
    EXPECT_NEAR(sums(end)[6], sums(start)[6], 0.01) << name_of(shape_names, shape.kind);
  }
}

TEST(BulletWorld, RefusesAConcaveMesh) {
  const TriangleMesh one = box_mesh({4e-6, 4e-6, 4e-6});
  Eigen::Matrix3Xd vertices_m(3, 16);
  vertices_m << one.vertices_m.colwise() - Eigen::Vector3d(4e-6, 0, 0),
      one.vertices_m.colwise() + Eigen::Vector3d(4e-6, 0, 0);
  TriangleMesh::Triangles triangles(3, 24);
  triangles << one.triangles, one.triangles.array() + 8;
  const BodySetup setup = setup_of({shaped("two boxes", {0, 0, 0}, mesh({vertices_m, triangles}))}, 1e-9);
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { engine_solver(setup); }), "body 'two boxes' has a concave mesh"));
}

TEST(BulletWorld, LetsNoCapsulePassThroughAWall) {
  for (int sample = 0; sample < 1500; ++sample) {
    const double tilt_rad = std::numbers::pi * (sample + 0.5) / 1500.0;
    BodySetup setup = falling_capsule(tilt_rad, 8.2e-6);
    setup.bodies[0].position_m.x() = 1e-7 * sample;
    EngineBodySolver bullet = engine_solver(setup);
    EXPECT_GT(advance(bullet, 900).position_m(2, 0), 4e-6) << tilt_rad;
  }
}

}  // namespace
}  // namespace copepod::body
