#include "contact/contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <unistd.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "geometry/contact_time.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double radius_m = 1e-3;
constexpr double mass_kg = 1e-5;
constexpr double gravity_m_per_s2 = 9.81;

BodySpecification ball(const std::string& name, const Eigen::Vector3d& position_m) {
  BodySpecification body = bead(name, position_m);
  body.shape.radius_m = radius_m;
  body.mass_kg = mass_kg;
  return body;
}

/// Its axis along z.
BodySpecification rod(const std::string& name, const Eigen::Vector3d& position_m) {
  BodySpecification body = ball(name, position_m);
  body.shape = {ShapeKind::capsule, radius_m, 4.0 * radius_m};
  return body;
}

WallSpecification wall(const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal, double friction = 0.0) {
  return {point_m, normal, Eigen::Vector3d::Zero(), friction};
}

WallSpecification floor_of(double friction = 0.0) { return wall({0, 0, 0}, {0, 0, 1}, friction); }

/// Bodies whose steps have two to four substeps.
BodySetup touching(std::vector<BodySpecification> bodies, double restitution, double friction = 0.0,
                   double stiffness_N_per_m = 100.0) {
  BodySetup setup = setup_of(std::move(bodies), 0.0, Integrator::semi_implicit_euler);
  setup.contact = {stiffness_N_per_m, restitution, friction};
  const double shortest_s = shortest_contact_s(stiffness_N_per_m, largest_inverse_mass_per_kg(setup.bodies));
  setup.step_s = 3.5 * shortest_s / substeps_per_contact;
  return setup;
}

void close_box(BodySetup& setup, const Eigen::Vector3d& size_m, double friction) {
  for (int axis = 0; axis < 3; ++axis) {
    setup.walls.push_back(wall({0, 0, 0}, Eigen::Vector3d::Unit(axis), friction));
    setup.walls.push_back(wall(size_m[axis] * Eigen::Vector3d::Unit(axis), -Eigen::Vector3d::Unit(axis), friction));
  }
}

double kinetic_energy_J(const Kinematics& state, const BodySetup& setup) {
  double energy = 0.0;
  for (Eigen::Index i = 0; i < state.bodies(); ++i) {
    const BodySpecification& body = setup.bodies[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d R = rotation_matrix(Eigen::Vector4d(state.orientation_wxyz.col(i)));
    const Eigen::Vector3d spin = R.transpose() * state.angular_velocity_rad_per_s.col(i);
    energy += 0.5 * body.mass_kg * state.velocity_m_per_s.col(i).squaredNorm() +
              0.5 * spin.dot(inertia_tensor_kg_m2(body.shape, body.mass_kg) * spin);
  }
  return energy;
}

class Restitution : public testing::TestWithParam<double> {
 protected:
  static constexpr double speed = 0.05;

  /// Advances until long after an impact that begins after `gap_m`.
  static Kinematics after_impact(const BodySetup& setup, double gap_m, double closing_m_per_s, double contacts = 3.0) {
    RigidBodySolver solver(setup);
    const double contact_s = std::numbers::pi * std::sqrt(mass_kg / setup.contact.stiffness_N_per_m);
    return advance(
        solver, static_cast<std::int64_t>(std::ceil((gap_m / closing_m_per_s + contacts * contact_s) / setup.step_s)));
  }

  /// Over impacts that begin at different places within a substep.
  template <class Impact>
  static void expect(const Impact& ratio_after) {
    for (const double gap_m : {1.0e-6, 3.1e-6, 5.3e-6, 7.7e-6, 9.2e-6})
      EXPECT_NEAR(ratio_after(gap_m), GetParam(), 0.01 * GetParam()) << "gap " << gap_m;
  }
};

TEST_P(Restitution, OfASphereOnAWallIsThatAskedFor) {
  expect([](double gap_m) {
    BodySetup setup = touching({ball("a", {0, 0, radius_m + gap_m})}, GetParam());
    setup.bodies[0].velocity_m_per_s = {0, 0, -speed};
    setup.walls = {floor_of()};
    return after_impact(setup, gap_m, speed).velocity_m_per_s(2, 0) / speed;
  });
}

TEST_P(Restitution, OfTwoSpheresIsThatAskedFor) {
  expect([](double gap_m) {
    const Eigen::Vector3d along = Eigen::Vector3d(1, -2, 2).normalized();
    BodySetup setup = touching({ball("a", {0, 0, 0}), ball("b", (3.0 * radius_m + gap_m) * along)}, GetParam());
    setup.bodies[1].shape.radius_m *= 2.0;
    setup.bodies[1].mass_kg *= 3.0;
    setup.bodies[0].velocity_m_per_s = speed * along;
    const Kinematics after = after_impact(setup, gap_m, speed);
    const Eigen::Vector3d momentum = after.velocity_m_per_s * Eigen::Vector2d(1.0, 3.0);
    EXPECT_LT((momentum - speed * along).norm(), 1e-12 * speed);
    return along.dot(after.velocity_m_per_s.col(1) - after.velocity_m_per_s.col(0)) / speed;
  });
}

/// Two long rods across a periodic box, whose nearest centres are not those of the images that meet.
Kinematics rods_after_impact(double period_m, double friction) {
  constexpr double third_m = radius_m / 3.0;
  BodySetup setup = touching(
      {rod("a", {14 * third_m, 9 * third_m, 9 * third_m}), rod("b", {14 * third_m, 16 * third_m, 26.8 * third_m})}, 0.5,
      friction);
  for (BodySpecification& body : setup.bodies) body.shape.length_m = 14.0 * third_m;
  setup.bodies[0].orientation_wxyz = Eigen::Vector4d(1.0, -std::tan(std::numbers::pi / 8), 0, 0).normalized();
  setup.bodies[1].velocity_m_per_s = {0.01, 0, -0.05};
  setup.periodic_length_m = {0.0, period_m, period_m};
  RigidBodySolver solver(setup);
  return advance(solver, static_cast<std::int64_t>(0.5 * radius_m / 0.05 / setup.step_s));
}

TEST(Contacts, MeetImagesThatAreNotTheNearest) {
  for (const double friction : {0.0, 0.3}) {
    const Kinematics expected = rods_after_impact(0.0, friction),
                     found = rods_after_impact(28.0 * radius_m / 3.0, friction);
    EXPECT_GT(std::abs(expected.velocity_m_per_s(2, 1) + 0.05), 0.01) << "they have met";
    EXPECT_LT((found.velocity_m_per_s - expected.velocity_m_per_s).norm(), 1e-9);
    EXPECT_LT((found.angular_velocity_rad_per_s - expected.angular_velocity_rad_per_s).norm(), 1e-6);
  }
}

TEST_P(Restitution, OnAFixedBodyIsThatAskedFor) {
  expect([](double gap_m) {
    BodySetup setup = touching({ball("a", {0, 0, 0}), ball("b", {0, 0, 2.0 * radius_m + gap_m})}, GetParam());
    setup.bodies[0].motion = MotionKind::fixed;
    setup.bodies[1].velocity_m_per_s = {0, 0, -speed};
    return after_impact(setup, gap_m, speed).velocity_m_per_s(2, 1) / speed;
  });
}

TEST_P(Restitution, OfALyingCapsuleIsThatAskedFor) {
  expect([](double gap_m) {
    BodySetup setup = touching({rod("a", {0, 0, radius_m + gap_m})}, GetParam());
    setup.bodies[0].orientation_wxyz = Eigen::Vector4d(1, 0, 1, 0).normalized();
    setup.bodies[0].velocity_m_per_s = {0, 0, -speed};
    setup.walls = {floor_of()};
    return after_impact(setup, gap_m, speed).velocity_m_per_s(2, 0) / speed;
  });
}

TEST_P(Restitution, AtTheEndOfATiltedCapsuleIsThatAskedFor) {
  expect([](double gap_m) {
    constexpr double angle = 0.9;
    constexpr double slow = 0.2 * speed;  // it hardly turns during the contact
    BodySetup setup = touching({rod("a", {0, 0, radius_m + 2.0 * radius_m * std::cos(angle) + gap_m})}, GetParam());
    setup.bodies[0].orientation_wxyz = {std::cos(0.5 * angle), 0, std::sin(0.5 * angle), 0};
    setup.bodies[0].velocity_m_per_s = {0, 0, -slow};
    setup.walls = {floor_of()};
    const Kinematics after = after_impact(setup, gap_m, slow);
    const Eigen::Vector3d end = 2.0 * radius_m * Eigen::Vector3d(-std::sin(angle), 0, -std::cos(angle));
    const Eigen::Vector3d spin = after.angular_velocity_rad_per_s.col(0);
    return (after.velocity_m_per_s(2, 0) + spin.cross(end).z()) / slow;
  });
}

TEST_P(Restitution, OfASphereOnTheSideOfACapsuleIsThatAskedFor) {
  expect([](double gap_m) {
    BodySetup setup = touching({rod("a", {0, 0, 0}), ball("b", {2.0 * radius_m + gap_m, 0, 0})}, GetParam());
    setup.bodies[1].velocity_m_per_s = {-speed, 0, 0};
    const Kinematics after = after_impact(setup, gap_m, speed);
    return (after.velocity_m_per_s(0, 1) - after.velocity_m_per_s(0, 0)) / speed;
  });
}

/// A sphere of which a joint to a heavy one takes the freedom, and which something heavy hits.
class JointedRestitution : public Restitution {
 protected:
  static BodySetup held(JointKind kind, const Eigen::Vector3d& other_m, std::vector<BodySpecification> hit_by) {
    std::vector<BodySpecification> bodies{ball("a", {0, 0, 0}), ball("b", other_m)};
    bodies[1].mass_kg *= 10.0;
    bodies.insert(bodies.end(), hit_by.begin(), hit_by.end());
    BodySetup setup = touching(bodies, GetParam());
    setup.joints = {{kind, 0, 1, other_m}};
    return setup;
  }
  static constexpr double slow = 0.01 * speed;  // the joint hardly turns during the contact
  static constexpr std::array kinds{JointKind::fixed, JointKind::hinge, JointKind::ball, JointKind::slider};
  static inline const std::array<Eigen::Vector3d, 3> places_m{
      {{3.0 * radius_m, 0, 0}, {2.0 * radius_m, 3.0 * radius_m, 0}, {radius_m, 2.0 * radius_m, -2.0 * radius_m}}};
};

TEST_P(JointedRestitution, OfTwoSpheresIsThatAskedFor) {
  for (const JointKind kind : kinds) {
    for (const Eigen::Vector3d& place_m : places_m) {
      BodySpecification thrown = ball("c", {-2.0 * radius_m - 3.1e-6, 0, 0});
      thrown.mass_kg *= 10.0;
      thrown.velocity_m_per_s = {slow, 0, 0};
      const BodySetup setup = held(kind, place_m, {thrown});
      const Kinematics after = after_impact(setup, 3.1e-6, slow, 6.0);
      EXPECT_NEAR((after.velocity_m_per_s(0, 0) - after.velocity_m_per_s(0, 2)) / slow, GetParam(), 0.01 * GetParam())
          << static_cast<int>(kind) << ", " << place_m.transpose();
      const Eigen::Vector3d momentum = after.velocity_m_per_s * Eigen::Vector3d(1, 10, 10);
      EXPECT_LT((momentum - Eigen::Vector3d(10.0 * slow, 0, 0)).norm(), 1e-12 * slow);
    }
  }
}

TEST_P(JointedRestitution, OnAWallIsThatAskedFor) {
  for (const JointKind kind : kinds) {
    for (const Eigen::Vector3d& place_m : places_m) {
      BodySetup setup = held(kind, place_m, {});
      setup.walls = {wall({-radius_m - 3.1e-6, 0, 0}, {1, 0, 0})};
      for (BodySpecification& body : setup.bodies) body.velocity_m_per_s = {-slow, 0, 0};
      EXPECT_NEAR(after_impact(setup, 3.1e-6, slow, 6.0).velocity_m_per_s(0, 0) / slow, GetParam(), 0.01 * GetParam())
          << static_cast<int>(kind) << ", " << place_m.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Contacts, JointedRestitution, testing::Values(0.2, 0.5, 0.9, 1.0));

INSTANTIATE_TEST_SUITE_P(Contacts, Restitution, testing::Values(0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0));

TEST(Contacts, ReboundAcrossAPeriodicFace) {
  BodySetup setup = touching({ball("a", {1.5e-3, 0, 0}), ball("b", {8.6e-3, 0, 0})}, 0.5);
  setup.periodic_length_m = {1e-2, 0, 0};
  setup.bodies[1].velocity_m_per_s = {0.5, 0, 0};
  RigidBodySolver solver(setup);
  const Kinematics after = advance(solver, static_cast<std::int64_t>(8e-3 / setup.step_s));
  EXPECT_NEAR(after.velocity_m_per_s(0, 0) - after.velocity_m_per_s(0, 1), 0.25, 0.0025);
}

/// A slope along x whose angle is `part` of that of friction.
BodySetup on_a_slope(const BodySpecification& body, double friction, double tangent) {
  BodySetup setup = touching({body}, 0.2, friction);
  setup.integrator = Integrator::runge_kutta_4;  // Euler's velocities at rest are half a substep's weight off
  const double angle = std::atan(tangent);
  setup.gravity_m_per_s2 = gravity_m_per_s2 * Eigen::Vector3d(std::sin(angle), 0, -std::cos(angle));
  setup.walls = {floor_of(friction)};
  return setup;
}

/// Speed along the slope at two times, 0.05 s apart.
std::pair<double, double> speeds_on(const BodySetup& setup) {
  RigidBodySolver solver(setup);
  const auto steps = static_cast<std::int64_t>(0.05 / setup.step_s);
  const double first = advance(solver, steps).velocity_m_per_s(0, 0);
  return {first, advance(solver, steps).velocity_m_per_s(0, 0)};
}

BodySpecification lying_rod() {
  BodySpecification body = rod("a", {0, 0, radius_m});
  body.orientation_wxyz = Eigen::Vector4d(1, 0, 1, 0).normalized();
  return body;
}

TEST(Friction, HoldsACapsuleBelowTheAngleOfFriction) {
  const double speed_m_per_s = speeds_on(on_a_slope(lying_rod(), 0.4, 0.98 * 0.4)).second;
  EXPECT_LT(std::abs(speed_m_per_s), 1e-6 * gravity_m_per_s2 * 0.05);
}

TEST(Friction, LetsACapsuleSlideAboveTheAngleOfFriction) {
  constexpr double friction = 0.4;
  const auto [first, second] = speeds_on(on_a_slope(lying_rod(), friction, 1.02 * friction));
  const double angle = std::atan(1.02 * friction);
  const double expected = gravity_m_per_s2 * (std::sin(angle) - friction * std::cos(angle)) * 0.05;
  EXPECT_NEAR(second - first, expected, 0.01 * expected);
}

TEST(Friction, MakesASphereRollDownASlope) {
  constexpr double tangent = 0.3;
  const BodySetup setup = on_a_slope(ball("a", {0, 0, radius_m}), 0.5, tangent);
  const auto [first, second] = speeds_on(setup);
  const double expected = 5.0 / 7.0 * gravity_m_per_s2 * std::sin(std::atan(tangent)) * 0.05;
  EXPECT_NEAR(second - first, expected, 0.005 * expected);
}

/// Spheres and some capsules that fly about in a closed box; body i is at place order[i].
BodySetup crowd(double restitution, double friction, const std::vector<int>& order) {
  constexpr double spacing_m = 4.5e-3;
  std::vector<BodySpecification> bodies(order.size());
  for (int i = 0; i < static_cast<int>(order.size()); ++i) {
    const Eigen::Vector3d place =
        spacing_m * Eigen::Vector3d(0.5 + i % 3, 0.5 + i / 3 % 3, 0.5 + static_cast<int>(i / 9));
    BodySpecification body = ball("body " + std::to_string(100 + i), place);
    if (i % 5 == 0) body.shape = {ShapeKind::capsule, radius_m, radius_m};
    body.velocity_m_per_s = 0.1 * Eigen::Vector3d(std::sin(3.0 * i), std::cos(7.0 * i), std::sin(11.0 * i));
    body.angular_velocity_rad_per_s = 50.0 * Eigen::Vector3d(std::cos(5.0 * i), std::sin(13.0 * i), 0);
    bodies[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])] = body;
  }
  BodySetup setup = touching(std::move(bodies), restitution, friction);
  close_box(setup, Eigen::Vector3d::Constant(3.0 * spacing_m), friction);
  return setup;
}

std::vector<int> in_order() {
  std::vector<int> order(27);
  for (int i = 0; i < 27; ++i) order[static_cast<std::size_t>(i)] = i;
  return order;
}

TEST(Contacts, NeverCreateEnergy) {
  for (const auto& [restitution, friction] : {std::pair(1.0, 0.0), std::pair(1.0, 0.3), std::pair(0.6, 0.3)}) {
    const BodySetup setup = crowd(restitution, friction, in_order());
    RigidBodySolver solver(setup);
    const double start_J = kinetic_energy_J(advance(solver, 0), setup);
    double largest_J = 0.0;
    Kinematics state;
    for (int sample = 0; sample < 100; ++sample) {
      state = advance(solver, 40);
      largest_J = std::max(largest_J, kinetic_energy_J(state, setup));
    }
    EXPECT_LT(largest_J, (1.0 + 1e-3) * start_J) << restitution << " " << friction;
    if (restitution < 1.0) {
      EXPECT_LT(kinetic_energy_J(state, setup), 0.7 * start_J);
    }
  }
}

TEST(Contacts, GiveTheSameBitsInWhateverOrderTheBodiesAre) {
  std::vector<int> scattered = in_order();
  std::ranges::reverse(scattered);
  std::rotate(scattered.begin(), scattered.begin() + 7, scattered.end());  // clang 14 has no ranges::rotate
  std::swap(scattered[0], scattered[15]);
  BodySetup plain = crowd(0.6, 0.3, in_order());
  BodySetup mixed = crowd(0.6, 0.3, scattered);
  plain.gravity_m_per_s2 = mixed.gravity_m_per_s2 = {0, 0, -gravity_m_per_s2};
  RigidBodySolver first(plain);
  RigidBodySolver second(mixed);
  const Kinematics a = advance(first, 3000);
  const Kinematics b = advance(second, 3000);
  EXPECT_LT(a.position_m.row(2).mean(), 6e-3) << "nothing has fallen";
  for (int i = 0; i < 27; ++i) {
    EXPECT_EQ(a.position_m.col(i), b.position_m.col(scattered[static_cast<std::size_t>(i)])) << i;
    EXPECT_EQ(a.angular_velocity_rad_per_s.col(i),
              b.angular_velocity_rad_per_s.col(scattered[static_cast<std::size_t>(i)]));
  }
}

TEST(Contacts, AreResumedBitForBit) {
  BodySetup setup = crowd(0.6, 0.3, in_order());
  setup.gravity_m_per_s2 = {0, 0, -gravity_m_per_s2};
  RigidBodySolver whole(setup);
  advance(whole, 2000);
  const std::string file =
      (std::filesystem::temp_directory_path() / ("contacts_test_" + std::to_string(getpid()))).string();
  whole.save(file);
  RigidBodySolver resumed(setup);
  resumed.restore(file);
  std::filesystem::remove(file);
  EXPECT_EQ(whole.summarise().digest, resumed.summarise().digest);
  advance(whole, 500);
  advance(resumed, 500);
  EXPECT_EQ(whole.summarise().digest, resumed.summarise().digest);
}

// COPEPOD_HEAP: number of spheres, for a heap that takes longer.
TEST(Contacts, LetAHeapComeToRest) {
  const char* const chosen = std::getenv("COPEPOD_HEAP");
  const int count = chosen ? std::stoi(chosen) : 45;
  const int columns = static_cast<int>(std::cbrt(count) + 1e-9);
  std::vector<BodySpecification> bodies;
  constexpr double spacing_m = 2.2e-3;
  for (int i = 0; i < count; ++i) {
    const double shift = 0.03 * std::sin(17.0 * i);
    const int layer = i / (columns * columns);
    const Eigen::Vector3d place(0.6 + i % columns + shift, 0.6 + i / columns % columns - shift, 0.6 + layer);
    bodies.push_back(ball("body " + std::to_string(100 + i), spacing_m * place));
  }
  BodySetup setup = touching(bodies, 0.3, 0.5, 200.0);
  setup.gravity_m_per_s2 = {0, 0, -gravity_m_per_s2};
  close_box(setup, {(columns + 0.2) * spacing_m, (columns + 0.2) * spacing_m, 20.0 * spacing_m}, 0.5);
  RigidBodySolver solver(setup);
  double largest_J = 0.0;
  Kinematics state;
  for (int sample = 0; sample < 20; ++sample) {
    state = advance(solver, static_cast<std::int64_t>(0.025 / setup.step_s));
    largest_J = std::max(largest_J, kinetic_energy_J(state, setup));
  }
  EXPECT_GT(largest_J, 1e-3 * count * mass_kg * gravity_m_per_s2 * radius_m) << "nothing has fallen";
  EXPECT_LT(kinetic_energy_J(state, setup), 1e-4 * largest_J);
  EXPECT_GT(state.position_m.minCoeff(), 0.95 * radius_m);
}

TEST(Contacts, KeepASphereOnTheFloor) {
  BodySetup setup = touching({ball("a", {0, 0, radius_m})}, 0.5, 0.3);
  setup.integrator = Integrator::runge_kutta_4;
  setup.gravity_m_per_s2 = {0, 0, -gravity_m_per_s2};
  setup.walls = {floor_of(0.3)};
  RigidBodySolver solver(setup);
  const Kinematics state = advance(solver, static_cast<std::int64_t>(0.1 / setup.step_s));
  EXPECT_NEAR(state.position_m(2, 0), radius_m - mass_kg * gravity_m_per_s2 / setup.contact.stiffness_N_per_m, 1e-10);
  EXPECT_LT(state.velocity_m_per_s.norm(), 1e-6);
}

TEST(Contacts, RefuseBodiesThatOverlapAtTheStart) {
  const BodySetup setup = touching({ball("one", {0, 0, 0}), ball("two", {1.9 * radius_m, 0, 0})}, 0.5);
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { RigidBodySolver solver(setup); }),
                       "bodies 'one' and 'two' overlap by 1.000e-04 m at the start"));
}

TEST(Contacts, NameBodiesThatArePressedIntoEachOther) {
  BodySetup setup = touching({ball("one", {0, 0, 0}), ball("two", {2.1 * radius_m, 0, 0})}, 0.5, 0.0, 0.1);
  setup.bodies[0].velocity_m_per_s = {1.0, 0, 0};
  RigidBodySolver solver(setup);
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { advance(solver, 1000); }), "'one' and 'two' are pressed into"));
}

TEST(ContactLaw, FindsTheDampingRatioOfARestitution) {
  for (const double restitution : {0.05, 0.1, std::exp(-2.0), 0.2, 0.5, 0.9, 0.999, 1.0})
    EXPECT_NEAR(restitution_of(damping_ratio_of(restitution)), restitution, 1e-6);
  EXPECT_EQ(damping_ratio_of(1.0), 0.0);
}

// A corner of a cube has an arm of half its diagonal across a side: 1/m_eff = 2 (1/m + 3/m).
TEST(ContactTime, TakesTheTurningOfOtherShapesIntoAccount) {
  const BodySpecification cube = shaped("cube", {0, 0, 0}, box({8e-6, 8e-6, 8e-6}));
  EXPECT_NEAR(largest_inverse_mass_per_kg({cube}) * cube.mass_kg, 8.0, 1e-9);
}

TEST(ContactTime, CountsSubsteps) {
  BodySetup setup = touching({ball("a", {0, 0, 0}), rod("b", {0, 1, 0})}, 0.5);
  EXPECT_EQ(contact_substeps(setup), 4.0);
  setup.contact.stiffness_N_per_m *= 4.0;
  EXPECT_EQ(contact_substeps(setup), 7.0);
  setup.contact.stiffness_N_per_m = 0.0;
  EXPECT_EQ(contact_substeps(setup), 1.0);
  EXPECT_DOUBLE_EQ(stiffness_of_contact(shortest_contact_s(3.0, 2.0), 2.0), 3.0);
}

}  // namespace
}  // namespace copepod::body
