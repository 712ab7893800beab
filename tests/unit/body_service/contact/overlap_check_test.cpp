#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contact/contacts.hpp"
#include "contract/errors.hpp"

namespace copepod::body {
namespace {

constexpr double um = 1e-6;

std::string reason_at_start(const BodySetup& setup) {
  const BodyModel model(setup);
  NearPairs near_pairs(model.shapes(), 0.0, setup.periodic_length_m);
  OverlapCheck check(model, near_pairs);
  try {
    ThreadTeam alone(1);
    check.check(model.initial_state(), 3, alone);
  } catch (const SolverError& error) {
    EXPECT_EQ(error.step(), 3);
    return error.what();
  }
  return "no overlap";
}

/// Two bodies that touch when `gap` is zero; they overlap just inside and do not just outside.
void expect_contact_at(const BodySpecification& first, BodySpecification second, const Eigen::Vector3d& touching_m,
                       double tolerance_m = 1e-10) {
  const Eigen::Vector3d outwards = (touching_m - first.position_m).normalized();
  second.position_m = touching_m + tolerance_m * outwards;
  EXPECT_EQ(reason_at_start(setup_of({first, second}, 1e-9)), "no overlap");
  second.position_m = touching_m - tolerance_m * outwards;
  const std::string reason = reason_at_start(setup_of({first, second}, 1e-9));
  EXPECT_TRUE(contains(reason, "bodies '" + first.name + "' and '" + second.name + "' overlap by"));
}

BodySpecification lying(BodySpecification body) {
  body.orientation_wxyz = {std::sqrt(0.5), 0, std::sqrt(0.5), 0};  // axis along x
  return body;
}

TEST(OverlapCheck, FindsTheContactOfTwoSpheres) {
  expect_contact_at(bead("a", {0, 0, 0}), bead("b", {0, 0, 0}), {0, 0, 8 * um});
}

TEST(OverlapCheck, FindsTheContactOfASphereAndTheSideOfACapsule) {
  expect_contact_at(bead("a", {0, 0, 0}), capsule("b", {0, 0, 0}), {8 * um, 0, 0});
}

TEST(OverlapCheck, FindsTheContactOfASphereAndTheEndOfACapsule) {
  expect_contact_at(capsule("b", {0, 0, 0}), bead("a", {0, 0, 0}), {0, 0, 12 * um});
}

TEST(OverlapCheck, FindsTheContactOfTwoParallelCapsules) {
  expect_contact_at(capsule("a", {0, 0, 0}), capsule("b", {0, 0, 0}), {8 * um, 0, 0});
  expect_contact_at(capsule("a", {0, 0, 0}), capsule("b", {0, 0, 0}), {0, 0, 16 * um});
}

TEST(OverlapCheck, FindsTheContactOfCrossedCapsules) {
  expect_contact_at(capsule("a", {0, 0, 0}), lying(capsule("b", {0, 0, 0})), {0, 8 * um, 0});
  expect_contact_at(capsule("a", {0, 0, 0}), lying(capsule("b", {0, 0, 0})), {12 * um, 0, 0});
}

BodySpecification turned(BodySpecification body, const Eigen::Vector3d& angle_rad) {
  body.orientation_wxyz = rotated(angle_rad, body.orientation_wxyz);
  return body;
}

TEST(OverlapCheck, FindsTheContactOfOtherShapes) {
  const BodySpecification cube = shaped("cube", {0, 0, 0}, box({8 * um, 8 * um, 8 * um}));
  const BodySpecification disc = shaped("disc", {0, 0, 0}, cylinder(4 * um, 2 * um));
  const Eigen::Vector3d semi_axes_m(3 * um, 4 * um, 8 * um);
  const BodySpecification egg = shaped("egg", {0, 0, 0}, ellipsoid(semi_axes_m));
  const double eighth = 0.25 * std::numbers::pi;
  expect_contact_at(cube, bead("ball", {0, 0, 0}), {8 * um, 0, 0});
  expect_contact_at(cube, disc, {0, 0, 5 * um});
  expect_contact_at(disc, lying(capsule("rod", {0, 0, 0})), {12 * um, 0, 0});
  expect_contact_at(turned(cube, {0, 0, eighth}), turned(shaped("dice", {0, 0, 0}, cube.shape), {0, eighth, 0}),
                    {8 * std::numbers::sqrt2 * um, 0, 0});  // edge across edge
  expect_contact_at(egg, shaped("ovum", {0, 0, 0}, egg.shape), {0, 0, 16 * um});
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0.48, 0.64, 0.6), Eigen::Vector3d(-0.6, 0.48, 0.64)})
    expect_contact_at(egg, shaped("ovum", {0, 0, 0}, egg.shape), 2.0 * semi_axes_m.cwiseProduct(direction), 2e-8);
}

TEST(OverlapCheck, LetsABodyIntoAConcaveOneAsLongAsItFits) {
  BodySpecification ball = bead("ball", {0.01 * um, 0, 0});
  ball.shape.radius_m = 3.98 * um;
  EXPECT_EQ(reason_at_start(setup_of({shaped("trough", {0, 0, 0}, trough()), ball}, 1e-9)), "no overlap");
  ball.shape.radius_m = 4 * um;
  EXPECT_TRUE(contains(reason_at_start(setup_of({shaped("trough", {0, 0, 0}, trough()), ball}, 1e-9)),
                       "bodies 'trough' and 'ball' overlap by 1.000e-08 m"));
  BodySetup setup = setup_of({shaped("trough", {0, 0, 0}, trough())}, 1e-9);
  setup.periodic_length_m = {0, 29 * um, 0};
  EXPECT_TRUE(contains(reason_at_start(setup), "'trough' overlaps with its own periodic image by 1.000e-06 m"));
  setup.periodic_length_m = {0, 31 * um, 0};
  EXPECT_EQ(reason_at_start(setup), "no overlap");
}

TEST(OverlapCheck, SeesABodyInsideAnother) {
  BodySpecification small = bead("small", {1 * um, 0, 0});
  small.shape.radius_m = 1 * um;
  EXPECT_TRUE(
      contains(reason_at_start(setup_of({shaped("cube", {0, 0, 0}, box({8 * um, 8 * um, 8 * um})), small}, 1e-9)),
               "'cube' and 'small' overlap"));
}

TEST(OverlapCheck, ReportsTheDepthAndWhatToDo) {
  const std::string reason = reason_at_start(setup_of({bead("a", {0, 0, 0}), bead("b", {0, 0, 7.5 * um})}, 1e-9));
  EXPECT_TRUE(contains(reason, "5.000e-07 m"));
  EXPECT_TRUE(contains(reason, "further apart"));
}

TEST(OverlapCheck, SeesAcrossPeriodicFaces) {
  BodySetup setup = setup_of({bead("low", {0, 0, 2 * um}), bead("high", {0, 0, 97 * um})}, 1e-9);
  EXPECT_EQ(reason_at_start(setup), "no overlap");
  setup.periodic_length_m = {0, 0, 100 * um};
  EXPECT_TRUE(contains(reason_at_start(setup), "'low' and 'high' overlap by 3.000e-06 m"));
}

TEST(OverlapCheck, FindsTheNearestImageOfBodiesAsLongAsTheBox) {
  // The centres are nearer through the periodic face (14) than directly (16), but the bodies meet directly.
  BodySpecification lower = capsule("lower", {0, 0, 0});
  lower.shape = {ShapeKind::capsule, 1 * um, 20 * um};
  BodySpecification upper = capsule("upper", {0, 5 * um, 16 * um});
  upper.shape = {ShapeKind::capsule, 1 * um, 16 * um};
  upper.orientation_wxyz = Eigen::Vector4d(std::cos(0.3375), -std::sin(0.3375), 0, 0);
  BodySetup setup = setup_of({lower, upper}, 1e-9);
  setup.periodic_length_m = {0, 0, 30 * um};

  const auto distance = [&](int image) {
    const Eigen::Vector3d centre = upper.position_m + Eigen::Vector3d(0, 0, image * 30 * um);
    return segment_distance_m({lower.position_m, {0, 0, 10 * um}}, {centre, 8 * um * z_axis(upper.orientation_wxyz)});
  };
  ASSERT_LT(distance(0), 2 * um);
  ASSERT_GT(distance(-1), 2 * um);
  EXPECT_TRUE(contains(reason_at_start(setup), "'lower' and 'upper' overlap"));
}

TEST(OverlapCheck, SeesABodyThatMeetsItsOwnImage) {
  BodySetup setup = setup_of({capsule("snake", {0, 0, 0})}, 1e-9);
  setup.periodic_length_m = {10 * um, 10 * um, 15 * um};
  EXPECT_TRUE(contains(reason_at_start(setup), "'snake' overlaps with its own periodic image by 1.000e-06 m"));
  setup.bodies[0] = lying(setup.bodies[0]);
  setup.periodic_length_m = {17 * um, 9 * um, 9 * um};
  EXPECT_EQ(reason_at_start(setup), "no overlap");
}

TEST(OverlapCheck, CatchesABodyThatComesFromFarAway) {
  const BodySetup setup =
      setup_of({bead("target", {0, 0, 0}), bead("other", {0, 50 * um, 0}), bead("bullet", {0, 0, 500 * um})}, 1e-9);
  const BodyModel model(setup);
  // The place where pairs were listed last before the impact differs with the start.
  for (const double start : {500.0, 497.0, 494.0, 491.0}) {
    NearPairs near_pairs(model.shapes(), 0.0, {});
    OverlapCheck check(model, near_pairs);
    MotionState state = model.initial_state();
    ThreadTeam alone(1);
    for (double z = start; z > 8.05; z -= 0.1) {
      state.position_m(2, 2) = z * um;
      ASSERT_NO_THROW(check.check(state, 0, alone)) << "at " << z;
    }
    state.position_m(2, 2) = 7.99 * um;
    EXPECT_TRUE(contains(reason_of<SolverError>([&] { check.check(state, 0, alone); }), "'target' and 'bullet'"));
  }
}

TEST(OverlapCheck, CatchesACapsuleThatTurnsIntoItsNeighbour) {
  BodySpecification rod = capsule("rod", {0, 0, 0});
  rod.shape.length_m = 40 * um;
  const BodySetup setup = setup_of({rod, bead("post", {15 * um, 0, 0})}, 1e-9);
  const BodyModel model(setup);
  NearPairs near_pairs(model.shapes(), 0.0, {});
  OverlapCheck check(model, near_pairs);
  MotionState state = model.initial_state();
  ThreadTeam alone(1);
  const auto turn_to = [&](double angle) {
    state.orientation_wxyz.col(0) << std::cos(angle / 2), 0, std::sin(angle / 2), 0;
  };
  const double contact_angle = std::numbers::pi / 2 - std::asin(8.0 / 15.0);
  for (double angle = 0.0; angle < contact_angle - 0.01; angle += 0.01) {
    turn_to(angle);
    ASSERT_NO_THROW(check.check(state, 0, alone)) << "at " << angle;
  }
  turn_to(contact_angle + 0.01);
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { check.check(state, 0, alone); }), "'rod' and 'post'"));
}

}  // namespace
}  // namespace copepod::body
