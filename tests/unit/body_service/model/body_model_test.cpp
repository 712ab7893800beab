#include "model/body_model.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"

namespace copepod::body {
namespace {

std::string refusal(const std::function<void(BodySpecification&)>& spoil) {
  BodySpecification body = capsule("odd one", {0, 0, 0});
  spoil(body);
  return reason_of<CaseError>([&] { const BodyModel model(setup_of({body}, 1e-9)); });
}

TEST(BodyModel, NamesTheBodyAndTheProblemOfAnImpossibleBody) {
  EXPECT_TRUE(contains(refusal([](auto& body) { body.mass_kg = 0.0; }), "body 'odd one': mass_kg"));
  EXPECT_TRUE(
      contains(refusal([](auto& body) { body.mass_kg = std::numeric_limits<double>::quiet_NaN(); }), "mass_kg"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.shape.radius_m = -1.0; }), "radius_m"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.shape.length_m = -1.0; }), "length_m"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.orientation_wxyz = {1, 1, 0, 0}; }), "orientation_wxyz"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.orientation_wxyz.setConstant(std::nan("")); }), "orientation"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.position_m[1] = std::nan(""); }), "not finite"));
}

TEST(BodyModel, NamesWhatIsWrongWithAShapeOrItsInertia) {
  const auto shape = [](Shape shape) { return [shape](BodySpecification& body) { body.shape = shape; }; };
  const auto inertia = [](std::vector<double> numbers) {
    return [numbers](BodySpecification& body) { body.inertia_kg_m2 = numbers; };
  };
  const double r = 4e-6;
  const double I = 1e-24;
  const auto inside_out =
      std::make_shared<const TriangleMesh>(-box_mesh({r, r, r}).vertices_m, box_mesh({r, r, r}).triangles);
  for (const auto& [spoil, part] : std::vector<std::pair<std::function<void(BodySpecification&)>, std::string>>{
           {shape({ShapeKind::cylinder, r, 0.0}), "length_m"},
           {shape({ShapeKind::ellipsoid, r, 0.0, {r, 0.0, r}}), "extents"},
           {shape({ShapeKind::box, r, 0.0, {r, r, std::nan("")}}), "extents"},
           {shape({ShapeKind::mesh, r}), "mesh encloses no volume"},
           {shape({.kind = ShapeKind::mesh, .radius_m = r, .mesh = std::make_shared<const TriangleMesh>()}),
            "no volume"},
           {shape({.kind = ShapeKind::mesh, .radius_m = r, .mesh = inside_out}), "no volume"},
           {shape({ShapeKind::compound, r}), "no parts"},
           {shape({.kind = ShapeKind::compound, .radius_m = r, .parts = {{{ShapeKind::sphere, -r}}}}), "radius_m"},
           {inertia({I, I, I}), "inertia_kg_m2"},
           {inertia({I, I, I, std::nan(""), 0, 0}), "inertia_kg_m2"},
           {inertia({I, I, -I, 0, 0, 0}), "positive"},
           {inertia({I, I, 2.1 * I, 0, 0, 0}), "sum of the other two"},
           {inertia({I, I, I, 0.6 * I, 0, 0}), "sum of the other two"}})
    EXPECT_TRUE(contains(refusal(spoil), part));
  BodySpecification disc = capsule("thin disc", {0, 0, 0});
  disc.inertia_kg_m2 = {I, I, 2.0 * I, 0, 0, 0};
  EXPECT_NO_THROW(BodyModel(setup_of({disc}, 1e-9)));
}

const Eigen::Vector3d tilted = Eigen::Vector3d(1, 2, 2) / 3.0;

BodyModel model_of(MotionKind motion, const Eigen::Vector3d& velocity = {0, 0, 0}) {
  BodySpecification body = bead("a", {0, 0, 0});
  body.motion = motion;
  body.axis = tilted;
  body.velocity_m_per_s = velocity;
  return BodyModel(setup_of({body}, 1e-9));
}

TEST(BodyModel, LeavesOnlyTheLoadsAlongTheAxis) {
  Eigen::Vector3d force(9, 0, 0);
  Eigen::Vector3d torque(0, 9, -9);
  model_of(MotionKind::axis).constrain_loads(0, force, torque);
  EXPECT_TRUE(force.isApprox(3.0 * tilted, 1e-15));
  EXPECT_LT(torque.norm(), 1e-15);
}

TEST(BodyModel, BalancesAllLoadsOnFixedAndPrescribedBodies) {
  for (const MotionKind motion : {MotionKind::fixed, MotionKind::prescribed}) {
    Eigen::Vector3d force(1, 2, 3);
    Eigen::Vector3d torque(4, 5, 6);
    model_of(motion).constrain_loads(0, force, torque);
    EXPECT_TRUE(force.isZero(0.0));
    EXPECT_TRUE(torque.isZero(0.0));
  }
}

TEST(BodyModel, LeavesTheLoadsOnFreeBodiesAlone) {
  Eigen::Vector3d force(1, 2, 3);
  Eigen::Vector3d torque(4, 5, 6);
  model_of(MotionKind::free).constrain_loads(0, force, torque);
  EXPECT_EQ(force, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(torque, Eigen::Vector3d(4, 5, 6));
}

TEST(BodyModel, RefusesAVelocityOffTheAxis) {
  const BodyModel along = model_of(MotionKind::axis, 5.0 * tilted);
  EXPECT_TRUE(along.initial_state().velocity_m_per_s.col(0).isApprox(5.0 * tilted));
  EXPECT_TRUE(contains(reason_of<CaseError>([] {
                         model_of(MotionKind::axis, {1, 0, 0});
                       }),
                       "body 'a': velocity_m_per_s points off its axis"));
  const auto turning = [](auto& body) {
    body.motion = MotionKind::axis;
    body.angular_velocity_rad_per_s = {0, 1, 0};
  };
  EXPECT_TRUE(contains(refusal(turning), "angular_velocity_rad_per_s points off its axis"));
}

TEST(BodyModel, RefusesAnAxisOrAMotionThatIsNone) {
  const auto stretched = [](auto& body) {
    body.motion = MotionKind::axis;
    body.axis = {0, 0, 2};
  };
  EXPECT_TRUE(contains(refusal(stretched), "axis has length 2"));
  EXPECT_TRUE(
      contains(refusal([](auto& body) { body.motion = static_cast<MotionKind>(9); }), "unknown kind of motion"));
}

TEST(BodyModel, RefusesAFixedBodyThatMoves) {
  EXPECT_TRUE(contains(reason_of<CaseError>([] { model_of(MotionKind::fixed, {1, 0, 0}); }), "fixed never moves"));
  EXPECT_TRUE(model_of(MotionKind::fixed).initial_state().velocity_m_per_s.isZero(0.0));
}

TEST(BodyModel, GivesBackTheAngularVelocityItWasGiven) {
  BodySpecification body = capsule("a", {0, 0, 0});
  body.orientation_wxyz = Eigen::Vector4d(0.3, -0.5, 0.7, 0.4).normalized();
  body.angular_velocity_rad_per_s = {1.0, -2.0, 3.0};
  const BodyModel model(setup_of({body}, 1e-9));
  const MotionState& state = model.initial_state();
  const Eigen::Vector3d w =
      model.angular_velocity_rad_per_s(0, state.orientation_wxyz.col(0), state.angular_momentum_N_m_s.col(0));
  EXPECT_TRUE(w.isApprox(body.angular_velocity_rad_per_s, 1e-14));
}

TEST(BodyModel, GivesAFreeCapsuleTheAngularMomentumOfItsFullTensor) {
  BodySpecification body = capsule("a", {0, 0, 0});
  body.orientation_wxyz = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};  // axis along −y
  body.angular_velocity_rad_per_s = {1.0, 1.0, 0.0};
  const BodyModel model(setup_of({body}, 1e-9));
  const Eigen::Matrix3d inertia = inertia_tensor_kg_m2(body.shape, body.mass_kg);
  const Eigen::Vector3d expected(inertia(0, 0), inertia(2, 2), 0.0);
  EXPECT_TRUE(model.initial_state().angular_momentum_N_m_s.col(0).isApprox(expected, 1e-14));
}

}  // namespace
}  // namespace copepod::body
